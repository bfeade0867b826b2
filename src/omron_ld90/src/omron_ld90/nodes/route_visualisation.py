"""Shows the state of the robot and the fleet: graph, route, destination, driven path, status.

The node sends no command, so it may be stopped or changed at any time. This is why it is separate
from `goal_sender`, whose clicks move the robot. `map_visualisation` shows no robot, so it is a
separate node as well.

Subscribes
    /graph (itrci_nav_msgs/Graph, latched): replaces the graph of ~graph_file
    execution_route_states (itrci_nav_msgs/ExecutionRouteStates)
    robot_status (omron_ld90_msgs/RobotStatus), link_state (omron_ld90_msgs/LinkState)
    pose (geometry_msgs/PoseStamped), move_base_simple/goal (geometry_msgs/PoseStamped)
    map_file (std_msgs/String, latched) of map_visualisation, map_metadata (nav_msgs/MapMetaData,
        latched)
Publishes
    graph_markers (visualization_msgs/MarkerArray, latched, complete): the trajectory graph
    route_markers (visualization_msgs/MarkerArray, latched, complete): the route, by state
    status_markers (visualization_msgs/MarkerArray): body, arrow, destination, banner; short-lived
    driven_path (nav_msgs/Path, latched): the path that the robot drove
Parameters
    robot_description  (URDF of the body, in the robot's namespace; without it no body is shown)
    ~graph_file   string  (empty)  trajectory graph (YAML); empty: none is shown until a /graph
    ~dock_vertex  int     0        id of the graph's dock vertex; 0: none
    ~map_frame    string  map
    ~silence      float   3.0 s    time without a status after which the robot counts as lost
    ~path_length  int     400      number of poses in the driven path, at least ~path_step apart
    ~path_step    float   0.1 m
    ~status_row   int     0        row above the map for this robot's banner; different per robot
"""
from __future__ import annotations

import math
import threading
import time
import xml.etree.ElementTree as ElementTree
from typing import Dict, List, Optional, Tuple

import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import MapMetaData, Path
from visualization_msgs.msg import Marker, MarkerArray

from graph_topic import FollowedGraph
from node_lifecycle import ConfigurationError, number, parameter, run
from node_lifecycle.periodic import Periodic
from omron_ld90.nodes.driven_path import DrivenPath
from omron_ld90.nodes.rviz.body_markers import body_markers
from omron_ld90.nodes.rviz.route_markers import GraphPicture
from omron_ld90.nodes.rviz.status_markers import banner, status_markers
from omron_ld90.nodes.support import shared_parameters
from omron_ld90.nodes.support.displayed_map import DisplayedMap
from omron_ld90.nodes.support.poses import is_plausible
from omron_ld90.nodes.support.route_states import MAX_EDGES, RouteStates
from omron_ld90.operator.goal_clicks import Target, TargetKind, target_named, targets_of
from omron_ld90.operator.route_watch import EdgeProgress, RouteView
from omron_ld90_msgs.msg import LinkState, RobotStatus
from omron_map import MapDocument
from rviz_drawing import drawing
from trajectory_graph import Graph

ROW_HEIGHT = 0.8  # m
LINKS = (LinkState.COMMANDS, LinkState.OUTGOING)
REFUSALS_TOLD = 60.0  # s between two log lines about reports that are not shown


class RouteVisualisation:
    """The node: see the module's text.

    The class has many attributes because it draws the contents of several topics about one robot.
    """

    def __init__(self) -> None:
        self._robot = rospy.get_namespace().strip('/') or 'robot'
        self._frame = parameter('~map_frame', 'map')
        self._dock_vertex = parameter('~dock_vertex', 0, int)
        self._silence = number('~silence', 3.0, 0.5, 60.0)
        self._path = DrivenPath(self._frame, int(number('~path_length', 400, 2, 10000)),
                                number('~path_step', 0.1, 0.01, 10.0))
        self._row = parameter('~status_row', 0, int)
        graph = shared_parameters.trajectory_graph()
        self._body = _body_of(parameter('robot_description', ''))

        self._lock = threading.Lock()
        self._status: Optional[RobotStatus] = None
        self._heard = -math.inf
        self._links: Dict[str, LinkState] = {}
        self._map_file = ''
        self._picture = GraphPicture(graph, self._dock_vertex, self._frame)
        self._targets: List[Target] = []
        self._point: Optional[drawing.XY] = None
        self._banner_at = (0.0, 0.0)
        self._route = RouteView()
        self._reported: Tuple[bytes, Tuple[EdgeProgress, ...]] = (b'', ())

        self._publish_status = rospy.Publisher(
            'status_markers', MarkerArray, queue_size=2, tcp_nodelay=True)
        self._publish_route = rospy.Publisher(
            'route_markers', MarkerArray, queue_size=2, latch=True, tcp_nodelay=True)
        self._publish_path = rospy.Publisher('driven_path', Path, queue_size=2, latch=True)
        self._publish_graph = rospy.Publisher(
            'graph_markers', MarkerArray, queue_size=1, latch=True)
        self._show_graph()
        self._show_route()
        FollowedGraph(self._on_graph, graph).subscribe()
        DisplayedMap(self._on_map, 'Destinations are not shown').subscribe()
        for topic, message, callback in (
                ('map_metadata', MapMetaData, self._on_metadata),
                ('execution_route_states', RouteStates, self._on_route),
                ('link_state', LinkState, self._on_link),
                ('move_base_simple/goal', PoseStamped, self._on_point),
                ('pose', PoseStamped, self._on_pose),
                ('robot_status', RobotStatus, self._on_status)):
            rospy.Subscriber(topic, message, callback, queue_size=10, tcp_nodelay=True)
        Periodic('drawing', 1.0, self._redraw)

    def _on_graph(self, graph: Graph, _stamp: rospy.Time) -> None:
        picture = GraphPicture(graph, self._dock_vertex, self._frame)
        with self._lock:
            self._picture = picture
            self._show_graph()
            self._show_route()

    def _on_map(self, document: Optional[MapDocument], path: str) -> None:
        targets = targets_of(document) if document else []
        with self._lock:
            self._targets = targets
            self._show_graph()
            if path != self._map_file:  # another map: the old path does not belong to it
                self._map_file = path
                self._path.clear()
                self._publish_path.publish(self._path.message)

    def _show_graph(self) -> None:
        named = {target.name: target.place for target in self._targets}
        self._publish_graph.publish(self._picture.graph_markers(named))

    def _show_route(self) -> None:
        self._publish_route.publish(self._picture.route_markers(self._route.shown))

    def _on_metadata(self, metadata: MapMetaData) -> None:
        if not is_plausible(metadata.origin):
            return
        origin = metadata.origin.position
        x = origin.x + metadata.width * metadata.resolution / 2
        top = origin.y + metadata.height * metadata.resolution
        with self._lock:
            self._banner_at = (x, top + ROW_HEIGHT * (self._row + 1))

    def _on_route(self, message: RouteStates) -> None:
        if message.too_long:
            rospy.logwarn_throttle(REFUSALS_TOLD, 'A report of route %d is not shown: it has more '
                                   'than %d edges.', message.route_id, MAX_EDGES)
            return
        with self._lock:
            content = message.edges.tobytes()
            if content != self._reported[0]:
                self._reported = content, tuple(
                    EdgeProgress(*edge) for edge in message.edges.tolist())
            if self._route.update(message.route_id, self._reported[1], time.monotonic()):
                self._show_route()

    def _on_link(self, message: LinkState) -> None:
        if message.link not in LINKS:
            return
        with self._lock:
            self._links[message.link] = message
            self._show_status()

    def _on_point(self, message: PoseStamped) -> None:
        if message.header.frame_id in ('', self._frame) and is_plausible(message.pose):
            with self._lock:
                self._point = (message.pose.position.x, message.pose.position.y)

    def _on_status(self, message: RobotStatus) -> None:
        with self._lock:
            self._status, self._heard = message, time.monotonic()
            self._show_status()

    def _on_pose(self, message: PoseStamped) -> None:
        if not is_plausible(message.pose):
            return
        with self._lock:
            if self._path.add(message):
                self._publish_path.publish(self._path.message)

    def _redraw(self) -> None:
        with self._lock:
            now = time.monotonic()
            if now - self._heard > 1.0:
                self._show_status()
            if self._route.expire(now):
                self._show_route()

    def _show_status(self) -> None:
        status = self._status
        silent_for = time.monotonic() - self._heard
        words = banner(self._robot, status, silent_for, list(self._links.values()), self._silence)
        pose = status.pose if status and status.has_pose and is_plausible(status.pose) else None
        self._publish_status.publish(status_markers(
            self._frame, words, self._banner_at, pose, silent_for <= self._silence,
            destination(status, self._targets, self._point) if status else None, self._body))


def destination(status: RobotStatus, targets: List[Target], point: Optional[drawing.XY]
                ) -> Optional[drawing.XY]:
    """Returns the robot's destination (m) if it is known.

    point -- the point to which the robot was last sent
    """
    target = None
    if status.activity == RobotStatus.GOING_TO_POINT:
        return point
    if status.activity == RobotStatus.GOING_TO_GOAL:
        target = target_named(status.goal, targets)
    elif status.activity == RobotStatus.DOCKING:
        target = next((t for t in targets if t.kind is TargetKind.DOCK), None)
    return target.place if target else None


def _body_of(urdf: str) -> List[Marker]:
    try:
        return body_markers(urdf) if urdf else []
    except (ElementTree.ParseError, KeyError, ValueError) as error:
        raise ConfigurationError(
            f'robot_description is no URDF that can be drawn ({error}). Correct it, or leave it '
            'out.') from error


def main() -> None:
    """Runs the node."""
    run('route_visualisation', RouteVisualisation)
