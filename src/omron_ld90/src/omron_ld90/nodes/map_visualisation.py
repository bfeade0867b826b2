"""Shows a `.map` file: markers for RViz and an occupancy grid for navigation software.

The file is loaded again when it has changed and is complete. If a new file is bad, the old map
stays on display, and /diagnostics and the log give the reason.

Topics out, all latched except `laser_markers`, all in the frame `~frame_id`:
  map (nav_msgs/OccupancyGrid), map_metadata (nav_msgs/MapMetaData): cells with the pitch of the map
      file, or a multiple of it if there would be more than 100 million cells
  map_file (std_msgs/String): path of the displayed file, published again after each (re)load
  map_markers/points, lines, goals, docks (visualization_msgs/Marker)
  map_markers/goal_names, goal_headings, forbidden_areas, sectors (visualization_msgs/MarkerArray)
  laser_markers (visualization_msgs/Marker): in the frame of `laser_cloud`
  /diagnostics
Topics in:
  laser_cloud (sensor_msgs/PointCloud2)
Services:
  static_map (nav_msgs/GetMap)
  change_map (nav_msgs/LoadMap): shows another file; `map_url` is a path, file:// or package:// URL
Parameters:
  ~map_file: `.map` file to show (required)
  ~base_map (''), ~graph_file (''): if base_map is set, the node first waits until the map is at
      least as new as both
  ~frame_id (map)
  ~background (unknown): value of cells without a point: unknown or free
  ~areas_in_grid (false): whether forbidden areas and lines are occupied in the grid
  ~default_resolution (0.05 m): cell size for maps that specify none
  ~laser_lifetime (2.0 s): time for which a laser reading is shown
"""
from __future__ import annotations

import os
import threading
import time
from dataclasses import dataclass
from typing import Mapping, Optional, Tuple
from urllib.parse import unquote, urlparse

import rospkg
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap, LoadMap, LoadMapRequest, LoadMapResponse
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header, String
from visualization_msgs.msg import Marker, MarkerArray

from node_lifecycle import choice, number, parameter, publish_diagnostics, run
from node_lifecycle.clouds import places_in
from omron_ld90.nodes.rviz import map_markers
from omron_ld90.nodes.support.poses import pose_from_robot
from omron_ld90.nodes.support.shared_parameters import map_sources
from omron_ld90.units import metres, millimetres
from omron_map import (
    FREE,
    UNKNOWN,
    MapDocument,
    MapError,
    MapWatcher,
    fitting_resolution,
    printable_path,
    wait_for_map,
)
from omron_map import (
    OccupancyGrid as Grid,
)
from rviz_drawing.fast_messages import GetGridResponse, GridMessage, LoadGridResponse

POLL_PERIOD = 0.5  # s between two checks of the file
MAX_WARNINGS = 10  # lines in the log about one file
REFUSALS_TOLD = 60.0  # s between two log lines about refused clouds
BACKGROUNDS = {'unknown': UNKNOWN, 'free': FREE}
MARKERS = {
    'map_markers/points': map_markers.points,
    'map_markers/lines': map_markers.lines,
    'map_markers/goals': map_markers.goals,
    'map_markers/docks': map_markers.docks,
}
MARKER_ARRAYS = {
    'map_markers/goal_names': map_markers.goal_names,
    'map_markers/goal_headings': map_markers.goal_headings,
    'map_markers/forbidden_areas': map_markers.forbidden_areas,
    'map_markers/sectors': map_markers.sectors,
}


@dataclass(frozen=True)
class MapSettings:
    """The settings of the display; lengths in m, times in s."""

    frame_id: str
    background: int
    areas_in_grid: bool
    default_resolution: float
    laser_lifetime: float


@dataclass(frozen=True)
class ShownMap:
    """The map on display: its grid, and its facts for the log and /diagnostics."""

    grid: GridMessage
    facts: Mapping[str, object]


class MapVisualisation:
    """The displayed map, its topics and services.

    A request for the displayed map is answered at once. It needs no lock, because a new map
    replaces the old one in one step. `_loading` is held while a map is loaded and shown, so that
    the later of two maps stays on display.
    """

    def __init__(self, settings: MapSettings, path: str, made_from: Tuple[str, ...] = ()) -> None:
        self._settings = settings
        self._loading = threading.Lock()
        self._watcher: Optional[MapWatcher] = None
        self._shown: Optional[ShownMap] = None
        self._problem = f'{printable_path(path)} was not loaded yet'
        self._markers = {
            build: rospy.Publisher(topic, message, queue_size=1, latch=True)
            for table, message in ((MARKERS, Marker), (MARKER_ARRAYS, MarkerArray))
            for topic, build in table.items()}
        self._map = rospy.Publisher('map', OccupancyGrid, queue_size=1, latch=True)
        self._metadata = rospy.Publisher('map_metadata', MapMetaData, queue_size=1, latch=True)
        self._file = rospy.Publisher('map_file', String, queue_size=1, latch=True)
        self._laser = rospy.Publisher('laser_markers', Marker, queue_size=5, tcp_nodelay=True)
        # The main thread must be free for signals; otherwise shutdown may never end.
        threading.Thread(target=self._follow_file, args=(path, made_from), daemon=True).start()
        rospy.Subscriber('laser_cloud', PointCloud2, self._draw_laser, queue_size=2,
                         tcp_nodelay=True)
        rospy.Service('static_map', GetMap, self._static_map)
        rospy.Service('change_map', LoadMap, self._change_map)
        publish_diagnostics('none', {'map': self._diagnose})

    def _follow_file(self, path: str, made_from: Tuple[str, ...]) -> None:
        """Shows the first map, and then each new version of the file."""
        try:
            if made_from:
                self._wait_for(path, made_from)
            with self._loading:
                if self._watcher is None:  # if not, change_map came first
                    self._watcher = MapWatcher(path)
                    if not self._watcher.unfinished:
                        self._try_to_show(path)
            while not rospy.is_shutdown():
                time.sleep(POLL_PERIOD)
                with self._loading:
                    if self._watcher.changed():
                        self._try_to_show(self._watcher.path)
        except rospy.ROSException:
            if not rospy.is_shutdown():  # at shutdown, topics may close during publishing
                raise

    def _wait_for(self, path: str, made_from: Tuple[str, ...]) -> None:
        try:
            wait_for_map(path, made_from, say=rospy.loginfo, given_up=rospy.is_shutdown)
        except MapError as error:
            self._report(error)

    def _try_to_show(self, path: str) -> None:
        try:
            self._show(path)
        except MapError as error:
            self._report(error)

    def _report(self, error: MapError) -> None:
        self._problem = str(error)
        if not rospy.is_shutdown():
            shown = 'The old map stays on display' if self._shown else 'No map is shown'
            rospy.logerr('%s until the file is corrected: %s', shown, error)

    def _show(self, path: str) -> ShownMap:
        """Loads `path`, and publishes the map on all topics. If it raises MapError, it publishes
        nothing.
        """
        document = MapDocument.load(path)
        frame_id, file = self._settings.frame_id, os.path.abspath(path)
        shown = ShownMap(self._grid_of(document), {
            'file': file, 'points': len(document.points), 'lines': len(document.lines),
            'goals': len(document.goals), 'docks': len(document.docks),
            'forbidden areas': len(document.forbidden_areas)})
        markers = [(publisher, build(document, frame_id))
                   for build, publisher in self._markers.items()]
        self._shown, self._problem = shown, ''
        self._map.publish(shown.grid)
        self._metadata.publish(shown.grid.info)
        for publisher, marker in markers:
            publisher.publish(marker)
        self._file.publish(file)
        rospy.loginfo('Showing %s.', ', '.join(f'{what}: {n}' for what, n in shown.facts.items()))
        _log_warnings(document, file)
        return shown

    def _grid_of(self, document: MapDocument) -> GridMessage:
        own_pitch = document.resolution or millimetres(self._settings.default_resolution)
        pitch = fitting_resolution(document, own_pitch)
        if pitch != own_pitch:
            rospy.logwarn('%s is so large that its grid has cells of %d mm instead of %d mm.',
                          document.name, pitch, own_pitch)
        grid = Grid.from_map(document, pitch, areas=self._settings.areas_in_grid,
                             background=self._settings.background)
        now = rospy.Time.now()
        info = MapMetaData(
            map_load_time=now, resolution=metres(pitch), width=grid.width,
            height=grid.height, origin=pose_from_robot(grid.origin[0], grid.origin[1], 0.0))
        header = Header(stamp=now, frame_id=self._settings.frame_id)
        return GridMessage(grid.cells, header=header, info=info)

    def _static_map(self, request: object) -> GetGridResponse:
        shown = self._shown
        if shown is None:
            raise rospy.ServiceException(f'no map is shown: {self._problem}')
        return GetGridResponse(shown.grid)

    def _change_map(self, request: LoadMapRequest) -> LoadMapResponse:
        try:
            path = _path(request.map_url)
        except (ValueError, rospkg.ResourceNotFound) as error:
            rospy.logerr('change_map: %s cannot be resolved: %s', printable_path(request.map_url),
                         printable_path(str(error)))
            return LoadMapResponse(result=LoadMapResponse.RESULT_MAP_DOES_NOT_EXIST)
        with self._loading:
            watcher = MapWatcher(path)
            try:
                shown = self._show(path)
            except MapError as error:
                rospy.logerr('change_map: the old map stays on display: %s', error)
                return LoadMapResponse(
                    result=LoadMapResponse.RESULT_INVALID_MAP_DATA if os.path.exists(path)
                    else LoadMapResponse.RESULT_MAP_DOES_NOT_EXIST)
            self._watcher = watcher
        return LoadGridResponse(shown.grid, LoadMapResponse.RESULT_SUCCESS)

    def _draw_laser(self, cloud: PointCloud2) -> None:
        try:
            places = places_in(cloud)
        except ValueError as error:
            rospy.logwarn_throttle(REFUSALS_TOLD, 'A laser_cloud is not drawn: %s.', error)
            return
        self._laser.publish(
            map_markers.laser(places, cloud.header, self._settings.laser_lifetime))

    def _diagnose(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        shown, problem = self._shown, self._problem
        if shown is None:
            status.summary(DiagnosticStatus.ERROR, f'No map is shown: {problem}')
            return status
        if problem:
            status.summary(DiagnosticStatus.WARN, f'The old map is shown: {problem}')
        else:
            status.summary(DiagnosticStatus.OK, f'Showing {shown.facts["file"]}')
        for name, value in shown.facts.items():
            status.add(name, str(value))
        return status


def _log_warnings(document: MapDocument, file: str) -> None:
    warnings = document.warnings
    for warning in warnings[:MAX_WARNINGS]:
        rospy.logwarn('%s, %s', file, warning)
    if len(warnings) > MAX_WARNINGS:
        rospy.logwarn('%d more warnings: ld_map check %s', len(warnings) - MAX_WARNINGS, file)


def _path(url: str) -> str:
    """Returns the path of a file that is given as a path or as a file:// or package:// URL."""
    parts = urlparse(url)
    if parts.scheme == 'package':
        package = rospkg.RosPack().get_path(parts.netloc)
        return os.path.join(package, unquote(parts.path).lstrip('/'))
    if parts.scheme == 'file':
        return unquote(parts.path)
    if '://' in url:
        raise ValueError('only file:// and package:// are known')
    return url


def _start() -> MapVisualisation:
    settings = MapSettings(
        frame_id=parameter('~frame_id', 'map'),
        background=BACKGROUNDS[choice('~background', 'unknown', tuple(BACKGROUNDS))],
        areas_in_grid=parameter('~areas_in_grid', False, bool),
        default_resolution=number('~default_resolution', 0.05, 0.005, 1.0),
        laser_lifetime=number('~laser_lifetime', 2.0, 0.05, 60.0))
    return MapVisualisation(settings, parameter('~map_file'), map_sources())


def main() -> None:
    """Runs the node."""
    run('map_visualisation', _start)
