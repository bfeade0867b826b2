"""fleet_page: shows the fleet in a browser, and passes people's requests to the fleet manager.

See docs/reference/fleet_page.md. The node decides nothing about robots. A second process, the door,
has all connections of browsers and carries out stops (fleet_page.door).

Subscribes
    /graph, /closed_edges_in_force, /parking, /docking_points (latched, of graph_server)
    /fleet_state, /fleet_plan, /fleet_poses, /mission_status (of path_supervisor)
    /mission_request, /mission_command, /edge_command: requests and their senders, for the audit
    /fleet_allocations (of path_supervisor), /<robot>/laser_cloud, while a browser shows them
    map_markers/forbidden_areas beside ~map_topic (latched, of map_visualisation): the fences
    /mission_templates, /timetables (latched, of path_supervisor)
    /plan_answer: the planning time
    ~map_topic (nav_msgs/OccupancyGrid, latched): the walls
Publishes
    /mission_request, /mission_command, /edge_command
    /edge_areas (itrci_nav_msgs/EdgeAreas, latched): the areas that users have named
    /<robot>/target_route: a direct stop if the fleet manager does not answer
Client of
    /stop_fleet, /resume_fleet, /<robot>/leave_fleet, /<robot>/join_fleet, /<robot>/declare_absent,
    /pause_timetable
Parameters
    ~listen      string  127.0.0.1   address to listen at; any other address needs ~token_file
    ~port        int     8080
    ~names       string  (empty)     further host names of the page, separated by commas
    ~token_file  string  (empty)     file with lines ROLE NAME TOKEN, mode 600
    ~certificate, ~key  string  (empty)  PEM files: the page is served by TLS
    ~fleet_file  string  (empty)     fleet file with the radii of the robots; empty: 0.4 m for all
    ~journal     string  graph_fleet_manager/fleet.sqlite in ROS_HOME
    ~folder      string  fleet_page in ROS_HOME: audit list, favourites, sums, replay
    ~map_topic   string  /fleet/map
"""
from __future__ import annotations

import asyncio
import math
import os
import shutil
import sqlite3
import tempfile
import threading
import time
from typing import Any, Callable, List, Mapping, Optional

import rospkg
import rospy
from aiohttp import web
from nav_msgs.msg import OccupancyGrid
from rospy.numpy_msg import numpy_msg
from visualization_msgs.msg import MarkerArray

from fleet_core.supervision.fleet_view import RobotState
from fleet_core.supervision.history import HistoryLine, history
from fleet_core.supervision.journal_database import JournalError, NoJournal
from fleet_core.supervision.readiness import Readiness
from fleet_core.work.stations import Destination, Station, UnknownPlace, destination_of
from fleet_page.core.acts import Act
from fleet_page.core.fleet_model import HOUR
from fleet_page.core.page import Page
from fleet_page.core.records import Records
from fleet_page.core.replay import ReplayRing
from fleet_page.core.site import WrongMap
from fleet_page.door.process import DoorError, DoorProcess, DoorSettings
from fleet_page.door.security import is_loopback
from fleet_page.nodes import messages
from fleet_page.nodes.fleet_commands import FleetCommands
from fleet_page.nodes.fleet_stop import forget_node_arguments, stop_fleet
from fleet_page.nodes.layer_topics import LayerTopics
from fleet_page.web.server import WebServer, serve
from graph_fleet_manager.messages.missions import stop_of
from graph_fleet_manager.messages.resources import stations_of
from graph_fleet_manager.nodes.fleet_parameter import fleet_of
from graph_topic import FollowedGraph
from itrci_nav_msgs.msg import (
    ClosedEdges,
    DockingPoints,
    EdgeAreas,
    EdgeCommand,
    FleetPlan,
    FleetPoses,
    FleetState,
    MissionCommand,
    MissionRequest,
    MissionStatus,
    MissionTemplates,
    ParkingPlaces,
    PlanAnswer,
    Timetables,
)
from node_lifecycle import ConfigurationError, parameter, run
from node_lifecycle.ready_line import announce_ready
from trajectory_graph import Graph

TICK = 0.2          # s between two runs of the periodic work
LOOK_UP = 3.0       # s between two readings of the journal while a mission's request is unknown
START_WITHIN = 5.0  # s within which the page must begin to listen


class FleetPageNode:
    """The node. Callbacks pass messages to the thread of the event loop, which owns the page.

    It connects many parts, so it has many attributes.
    """

    def __init__(self, door: DoorProcess) -> None:
        self._door, self._is_ending = door, threading.Event()
        self._sockets = tempfile.mkdtemp(prefix='fleet_page_')  # only this user can open it
        worker = os.path.join(self._sockets, 'page')
        settings = _door_settings(worker)
        folder = _folder()
        journal = _journal()
        try:
            self._records = Records(os.path.join(folder, 'page.sqlite'))
            replay = ReplayRing(os.path.join(folder, 'replay'))
        except (OSError, sqlite3.Error) as error:
            raise ConfigurationError(f'The folder {folder} cannot be used ({error}); choose '
                                     'another with ~folder.') from None

        def missions(since: float) -> List[HistoryLine]:
            return list(history(journal, since))
        self._areas = rospy.Publisher('/edge_areas', EdgeAreas, queue_size=1, latch=True)
        self._page = Page(self._records, replay, missions, self._publish_areas)
        if parameter('~fleet_file', ''):
            self._page.site.radii = messages.radii_of(fleet_of())
        self._stations: Mapping[str, Station] = {}
        commands = FleetCommands(lambda name: name in self._page.model.robots, self._destination)
        self._layer_topics = LayerTopics(self._page.model, self._loop_call)
        server = WebServer(self._page, commands.do, self._layer_topics.watch)
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._work, name='page', daemon=True)
        self._thread.start()
        self._runner: web.AppRunner = asyncio.run_coroutine_threadsafe(
            serve(server, worker), self._loop).result(START_WITHIN)
        try:
            door.open(settings)
        except DoorError as error:
            raise ConfigurationError(str(error)) from None
        threading.Thread(target=self._end_with_door, name='door', daemon=True).start()
        self._begun = time.time()
        asyncio.run_coroutine_threadsafe(self._tick(), self._loop)
        shown = 'localhost' if is_loopback(settings.listen) else settings.listen
        self._address = f'{"https" if settings.is_secure else "http"}://{shown}:{settings.port}'
        self._readiness, self._is_surveyed = Readiness(), False
        self._subscribers = self._subscribe(parameter('~map_topic', '/fleet/map'))
        rospy.loginfo('The fleet is shown at %s', self._address)

    def close(self) -> None:
        """Ends all connections."""
        self._is_ending.set()
        self._door.close()
        asyncio.run_coroutine_threadsafe(self._runner.cleanup(), self._loop)
        shutil.rmtree(self._sockets, ignore_errors=True)

    def _end_with_door(self) -> None:
        """Ends this process when the door has ended, so that roslaunch or systemd restarts both."""
        self._door.wait()
        if not self._is_ending.is_set():
            rospy.logfatal('The door of the page has ended: the page ends too.')
            os._exit(1)

    def _loop_call(self, handler: Callable[..., None], *values: Any) -> None:
        self._loop.call_soon_threadsafe(handler, *values)

    def _work(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_forever()

    async def _tick(self) -> None:
        looked, is_read = 0.0, False
        while not rospy.is_shutdown():
            now = time.time()
            self._page.tick(now)
            if not is_read and self._page.model.robots:  # now the fleet manager has a journal
                is_read = True
                await self._read_journal(now - HOUR)
            elif self._page.model.unknown and abs(now - looked) >= LOOK_UP:
                looked = now
                await self._read_journal(math.inf)
            await asyncio.sleep(TICK)

    async def _read_journal(self, since: float) -> None:
        """Reads missions from the journal: the open missions, and those that changed since `since`.
        """
        try:
            lines = await self._loop.run_in_executor(None, self._page.missions, since)
        except JournalError as error:
            if isinstance(error, NoJournal) and not self._page.model.unknown:
                return  # a new site: no mission was accepted yet
            rospy.logwarn_throttle(600.0, 'The destinations of missions from before the start are '
                                          f'not shown: {error}')
        else:
            self._page.model.note_history(lines)
            self._page.model.count_done(lines, self._begun)

    def _subscribe(self, map_topic: str) -> List[rospy.Subscriber]:
        def listen(topic: str, kind: Any, handler: Callable[[Any], None],
                   waiting: int = 1) -> rospy.Subscriber:
            def receive(message: Any) -> None:
                self._loop.call_soon_threadsafe(handler, message)
            return rospy.Subscriber(topic, kind, receive, queue_size=waiting)
        return [
            FollowedGraph(self._on_graph).subscribe(),
            listen('/closed_edges_in_force', ClosedEdges, self._on_closed),
            listen('/parking', ParkingPlaces, self._on_parking),
            listen('/docking_points', DockingPoints, self._on_docks),
            listen('/fleet_state', FleetState, self._on_state),
            listen('/fleet_plan', FleetPlan, self._on_plan),
            listen('/fleet_poses', FleetPoses, self._on_poses),
            listen('/mission_request', MissionRequest, self._on_request, 1000),
            listen('/mission_command', MissionCommand, self._on_command, 1000),
            listen('/edge_command', EdgeCommand, self._on_edges, 1000),
            listen('/mission_status', MissionStatus, self._on_status, 1000),
            listen('/mission_templates', MissionTemplates, self._on_templates),
            listen('/timetables', Timetables, self._on_timetables),
            listen('/plan_answer', PlanAnswer, self._on_answer, 10),
            listen(map_topic, numpy_msg(OccupancyGrid), self._on_map),
            listen(f'{map_topic.rpartition("/")[0]}/map_markers/forbidden_areas', MarkerArray,
                   self._on_fences)]

    def _on_graph(self, graph: Graph, _stamp: rospy.Time) -> None:
        self._loop.call_soon_threadsafe(self._use_graph, graph)

    # -- messages, in the thread of the event loop ------------------------------------------------

    def _use_graph(self, graph: Graph) -> None:
        self._page.model.graph = graph
        self._page.model.site_changed()

    def _on_closed(self, message: ClosedEdges) -> None:
        self._page.model.close_edges(message.edges)

    def _on_parking(self, message: ParkingPlaces) -> None:
        self._page.site.parking = frozenset(message.vertices)
        self._is_surveyed = True
        self._page.model.site_changed()

    def _on_docks(self, message: DockingPoints) -> None:
        self._page.site.docks = frozenset(point.vertex_id for point in message.docking_points)
        self._page.model.site_changed()

    def _on_map(self, message: OccupancyGrid) -> None:
        try:
            self._page.site.walls = messages.walls_of(message)
        except WrongMap as error:
            rospy.logwarn('The map is not shown: %s.', error)
            return
        self._page.model.site_changed()

    def _on_fences(self, message: MarkerArray) -> None:
        self._page.site.fences = messages.fences_of(message)
        self._page.model.site_changed()

    def _destination(self, word: str) -> Destination:
        """Returns the destination that a person named. Threads of the HTTP server call this method.
        """
        graph = self._page.model.graph
        if graph is None:
            raise UnknownPlace('there is no graph yet')
        return destination_of(word, self._stations, graph)

    def _on_state(self, message: FleetState) -> None:
        self._stations = stations_of(message.resources)
        self._page.model.show_stop(stop_of(message.stop))
        self._page.model.update_robots(messages.robots_of(message), time.time())
        self._page.model.show_resources(messages.resources_of(message),
                                        messages.machines_of(message))
        ready = self._readiness.words(
            {name: RobotState[robot.state] for name, robot in self._page.model.robots.items()},
            self._is_surveyed,
            stop_of(message.stop).is_in_force, time.monotonic())
        if ready:
            announce_ready(f'{ready} Open {self._address}, click destinations on the map, and '
                           'press Send.')

    def _on_poses(self, message: FleetPoses) -> None:
        self._page.model.update_places(messages.places_of(message))

    def _on_plan(self, message: FleetPlan) -> None:
        self._page.update_plans(messages.plans_of(message), time.time())

    def _on_request(self, message: MissionRequest) -> None:
        self._page.note_request(messages.request_of(message),
                                messages.sender_of(message, rospy.get_name()), time.time())

    def _on_command(self, message: MissionCommand) -> None:
        if message.command == MissionCommand.MODIFY:
            self._loop.call_later(1.0, self._page.model.forget_request, message.request_id)
        self._notice(message, messages.command_of(message))

    def _on_edges(self, message: EdgeCommand) -> None:
        self._notice(message, messages.edges_of(message))

    def _notice(self, message: Any, act: Optional[Act]) -> None:
        """Adds a request that did not come from this page to the audit list."""
        sender = messages.sender_of(message, rospy.get_name())
        if sender and act is not None:
            self._page.noticed(sender, act, time.time())

    def _on_status(self, message: MissionStatus) -> None:
        self._page.update_status(messages.status_of(message))

    def _on_templates(self, message: MissionTemplates) -> None:
        self._page.model.show_templates(messages.templates_of(message))

    def _on_timetables(self, message: Timetables) -> None:
        self._page.model.show_timetables(messages.timetables_of(message))

    def _publish_areas(self, areas: Mapping[str, Any]) -> None:
        message = messages.areas_message(areas)
        message.header.stamp = rospy.Time.now()
        self._areas.publish(message)

    def _on_answer(self, message: PlanAnswer) -> None:
        if message.result == PlanAnswer.PLANNED:
            self._page.planner.add(message.planning_time)


def _door_settings(worker: str) -> DoorSettings:
    """Returns the settings of the door; raises ConfigurationError."""
    settings = DoorSettings(
        parameter('~listen', '127.0.0.1'), parameter('~port', 8080, int), worker,
        os.path.join(rospkg.RosPack().get_path('fleet_page'), 'page'),
        tuple(name.strip() for name in parameter('~names', '').split(',') if name.strip()),
        parameter('~token_file', ''), parameter('~certificate', ''), parameter('~key', ''))
    if is_loopback(settings.listen):
        return settings
    if not settings.token_file:
        raise ConfigurationError(
            f'Parameter ~listen is {settings.listen}, so other computers can reach the page: set '
            '~token_file to a file with lines ROLE NAME TOKEN.')
    if not settings.is_secure:
        rospy.logwarn('The page is served without TLS: other computers on the network can read its '
                      'tokens. Set ~certificate and ~key.')
    return settings


def _folder() -> str:
    folder: str = parameter('~folder', '') or os.path.join(rospkg.get_ros_home(), 'fleet_page')
    try:
        os.makedirs(folder, mode=0o700, exist_ok=True)
    except OSError as error:
        raise ConfigurationError(f'The folder {folder} cannot be made ({error.strerror}); choose '
                                 'another with ~folder.') from None
    return folder


def _journal() -> str:
    journal: str = parameter('~journal', '')
    return journal or os.path.join(rospkg.get_ros_home(), 'graph_fleet_manager', 'fleet.sqlite')


def main() -> None:
    """Runs the node and its door."""
    door = DoorProcess(stop_fleet, forget_node_arguments)
    run('fleet_page', lambda: FleetPageNode(door))
