"""fleet_visualisation: shows the fleet in RViz, with menus that send missions and stop robots.

It draws the graph, the plans and the robots from the topics of the fleet manager. A robot that
publishes /<robot>/pose is drawn at that pose.

Subscribes
    /graph, /closed_edges_in_force, /parking, /docking_points (latched, of graph_server)
    /fleet_state, /fleet_plan (latched, of path_supervisor), /mission_status
    /<robot>/pose (geometry_msgs/PoseStamped) of every robot in /fleet_state, if it has that topic
Publishes
    /fleet_markers/graph, /fleet_markers/plans (visualization_msgs/MarkerArray, latched)
    /fleet_markers/robots (10 Hz), /fleet_markers/feedback (visualization_msgs/MarkerArray)
    /fleet_menus/update (visualization_msgs/InteractiveMarkerUpdate)
    /mission_request, /mission_command, /edge_command: requests and commands of the menus
    /<robot>/target_route (itrci_nav_msgs/TargetRoute): a direct stop if the fleet manager hangs
Client of (std_srvs/Trigger, except declare_absent)
    /stop_fleet, /resume_fleet, /<robot>/leave_fleet, /<robot>/join_fleet, /<robot>/declare_absent
Parameters
    ~fleet_file     string  (empty)  fleet file with the radii of the robots; empty: 0.4 m for all
    ~says_ready     bool    false    true: log once that the fleet is ready, and how to give it a
                                     mission. With the page, this is not needed: the page says it
"""
from __future__ import annotations

import threading
import time
from typing import Dict, FrozenSet, List, Optional

import rospy
from visualization_msgs.msg import Marker, MarkerArray

from fleet_core.supervision.fleet_view import RobotState
from fleet_core.supervision.readiness import Readiness
from graph_fleet_manager.messages.missions import stop_of
from graph_fleet_manager.nodes.fleet_acts import FleetActs
from graph_fleet_manager.nodes.fleet_parameter import fleet_of
from graph_fleet_manager.nodes.rviz.graph_picture import (
    GraphTexts,
    closed_boxes,
    graph_markers,
    place_texts,
    window_of,
)
from graph_fleet_manager.nodes.rviz.menus import FleetMenus
from graph_fleet_manager.nodes.rviz.picture import Picture
from graph_fleet_manager.nodes.rviz.plan_picture import plan_markers
from graph_fleet_manager.nodes.rviz.resource_picture import DrawnResources, draw_resources
from graph_fleet_manager.nodes.rviz.robot_picture import (
    DrawnPose,
    label_of,
    place_on_graph,
    robot_markers,
)
from graph_fleet_manager.nodes.rviz.sentence_picture import sentence_marker
from graph_fleet_manager.nodes.rviz.stop_picture import stop_markers
from graph_fleet_manager.nodes.rviz.true_places import TruePlaces
from graph_topic import FollowedGraph
from itrci_nav_msgs.msg import (
    ClosedEdges,
    DockingPoints,
    FleetPlan,
    FleetState,
    MissionStatus,
    ParkingPlaces,
)
from node_lifecycle import parameter, run
from node_lifecycle.periodic import Periodic
from node_lifecycle.ready_line import announce_ready
from rviz_drawing.label_places import Label, LabelPlaces
from trajectory_graph import Graph
from trajectory_graph.placing import Places

PERIOD = 0.1         # s between two pictures of the robots
SLOW = 3             # periods between two pictures of the plans, and between two moves of a handle
RADIUS = 0.4         # m, radius of a robot whose type is not known
_STATES: Dict[int, RobotState] = {int(state): state for state in RobotState}
_BAD = {MissionStatus.FAILED: 'failed', MissionStatus.REFUSED: 'was refused',
        MissionStatus.CANCELLED: 'was cancelled', MissionStatus.NEEDS_PERSON: 'needs a person',
        MissionStatus.EXPIRED: 'has expired'}


class FleetVisualisation:
    """The node; see the docstring of the module. `_lock` guards all that callbacks set.

    The attributes are the newest message of each topic, and the pictures that are drawn from these
    messages.
    """

    def __init__(self) -> None:
        self._radii: Dict[str, float] = {}
        if parameter('~fleet_file', ''):
            self._radii = {kind.name: kind.radius for kind in fleet_of().types}
        self._readiness = Readiness() if parameter('~says_ready', False, bool) else None
        self._lock = threading.RLock()
        self._graph: Optional[Graph] = None
        self._texts = GraphTexts(Places(), {})
        self._closed: FrozenSet[int] = frozenset()
        self._parking: Optional[FrozenSet[int]] = None  # None: the graph is not surveyed yet
        self._docks: FrozenSet[int] = frozenset()
        self._state, self._plan = FleetState(), FleetPlan()
        self._numbers: Dict[str, int] = {}
        self._changed = False
        self._ticks = 0
        self._places = TruePlaces()
        self._label_places = LabelPlaces()
        self._drawn = DrawnResources([])
        self._pictures = {name: Picture(f'/fleet_markers/{name}', latch=name != 'robots')
                          for name in ('graph', 'plans', 'robots')}
        self._feedback = rospy.Publisher('/fleet_markers/feedback', MarkerArray, queue_size=2)
        self._acts = FleetActs(self._say)
        self._menus = FleetMenus(self._acts.act)
        for topic, kind, callback in (
                ('/closed_edges_in_force', ClosedEdges, self._on_closed),
                ('/parking', ParkingPlaces, self._on_parking),
                ('/docking_points', DockingPoints, self._on_docks),
                ('/fleet_state', FleetState, self._on_state),
                ('/fleet_plan', FleetPlan, self._on_plan),
                ('/mission_status', MissionStatus, self._on_status)):
            rospy.Subscriber(topic, kind, callback, queue_size=20)
        FollowedGraph(self._on_graph).subscribe()
        Periodic('drawing', PERIOD, self._tick)

    # --- callbacks -------------------------------------------------------------------------------

    def _on_graph(self, graph: Graph, _stamp: rospy.Time) -> None:
        with self._lock:
            self._graph, self._texts = graph, place_texts(graph)
            self._menus.show_graph(graph)
            self._draw_graph()

    def _on_closed(self, message: ClosedEdges) -> None:
        with self._lock:
            self._closed = self._acts.closed = frozenset(message.edges)
            self._draw_graph()

    def _on_parking(self, message: ParkingPlaces) -> None:
        with self._lock:
            self._parking = frozenset(message.vertices)
            self._draw_graph()

    def _on_docks(self, message: DockingPoints) -> None:
        with self._lock:
            self._docks = frozenset(point.vertex_id for point in message.docking_points)
            self._draw_graph()

    def _on_state(self, message: FleetState) -> None:
        with self._lock:
            self._state = message
            self._changed = True
            self._acts.robots = {robot.name: robot for robot in message.robots}
            for robot in message.robots:
                self._numbers.setdefault(robot.name, len(self._numbers))
            self._say_ready(message)
        self._places.follow([robot.name for robot in message.robots])

    def _say_ready(self, state: FleetState) -> None:
        """Says once that the fleet is ready, if no page says it."""
        if self._readiness is None:
            return
        words = self._readiness.words(
            {robot.name: _STATES.get(robot.state, RobotState.UNKNOWN) for robot in state.robots},
            self._parking is not None, stop_of(state.stop).is_in_force, time.monotonic())
        if words:
            places = self._parking or (self._graph.vertices if self._graph else ())
            announce_ready(f'{words} Right click a vertex in RViz, or send a mission: rosrun '
                           f'graph_fleet_manager mission {min(places, default="VERTEX")}')

    def _on_plan(self, message: FleetPlan) -> None:
        with self._lock:
            self._plan, self._changed = message, True

    def _on_status(self, message: MissionStatus) -> None:
        with self._lock:
            self._acts.mission_said(message)
        if message.state in _BAD:
            why = f': {message.reason}' if message.reason else ''
            self._say(f'Mission {message.request_id} {_BAD[message.state]}{why}')

    # --- drawing ---------------------------------------------------------------------------------

    def _draw_graph(self) -> None:
        if self._graph is not None:
            docks = self._docks or frozenset(
                vertex.id for vertex in self._graph.vertices.values() if vertex.dock)
            self._pictures['graph'].show(graph_markers(
                self._graph, self._texts, self._closed, (self._parking or frozenset()) - docks,
                docks))

    def _tick(self) -> None:
        with self._lock:
            if self._graph is not None:
                self._draw(self._graph, self._state)

    def _draw(self, graph: Graph, state: FleetState) -> None:
        self._ticks += 1
        is_slow = self._ticks % SLOW == 0
        if is_slow and self._changed:  # first, because labels of robots keep clear of these words
            self._changed = False
            words = (*self._texts.names.values(),
                     *closed_boxes(graph, self._texts, self._closed).values())
            self._drawn = draw_resources(graph, state.resources, state.machines,
                                         window_of(graph), words, self._texts.edges)
            self._pictures['plans'].show([
                *self._drawn.markers, *plan_markers(graph, self._plan, state, self._numbers)])
        places = self._draw_robots(graph, state)
        if is_slow:
            self._menus.show_robots(places, self._acts.asks())

    def _draw_robots(self, graph: Graph, state: FleetState) -> Dict[str, DrawnPose]:
        """Draws all robots whose pose is known. Returns these poses."""
        now = rospy.Time.now().to_sec()
        places: Dict[str, DrawnPose] = {}
        labels: Dict[str, Label] = {}
        markers: List[Marker] = []
        for robot in state.robots:
            place = self._places.of(robot.name) or place_on_graph(robot, graph)
            place = place or self._places.last(robot.name)
            if place is not None:
                places[robot.name] = place
                labels[robot.name] = label_of(robot, place, self._radii.get(robot.type, RADIUS),
                                              now)
        if self._ticks % SLOW == 0:
            self._label_places.choose(labels, window_of(graph),
                                      (*self._texts.names.values(), *self._drawn.boxes,
                                       *self._drawn.rings),
                                      beneath=self._texts.edges)
        for robot in state.robots:
            if robot.name in places:
                markers += robot_markers(
                    robot, self._numbers[robot.name], places[robot.name], labels[robot.name],
                    self._label_places.side(robot.name), robot.name == self._acts.chosen)
        markers += stop_markers(graph, stop_of(state.stop), time.time())
        self._pictures['robots'].show(markers)
        return places

    def _say(self, sentence: str) -> None:
        """Shows a sentence above the graph for some seconds."""
        rospy.loginfo('%s', sentence)
        with self._lock:
            graph = self._graph
        if graph is not None:
            self._feedback.publish(MarkerArray([sentence_marker(graph, sentence)]))


def main() -> None:
    """Runs the node."""
    run('fleet_visualisation', FleetVisualisation)
