"""The bridge between the fleet manager, which thinks in edges, and the LD-90, which knows goals.

Takes routes of edges, sends the robot over their vertices, and tells how far it is, as
docs/interface/route_protocol.md says. What it thinks is in `omron_ld90.bridge.route_follower`.

Subscribes
    target_route (itrci_nav_msgs/TargetRoute): the route to drive
    /graph (itrci_nav_msgs/Graph): replaces the graph of ~graph_file
    robot_status (omron_ld90_msgs/RobotStatus), link_state (omron_ld90_msgs/LinkState)
    arcl_response (std_msgs/String): what the robot says
    command_refused (omron_ld90_msgs/CommandRefused): a refused command of ours ends the route
    send_command (std_msgs/String): a motion command of somebody else ends the route
Publishes
    send_command (std_msgs/String): goto, dock, stop
    execution_route_states (itrci_nav_msgs/ExecutionRouteStates, latched): 10 Hz and on change
        while a route runs, else 1 Hz
    /diagnostics
Parameters
    ~graph_file        string  (empty)  trajectory graph (YAML); empty: wait for /graph
    ~dock_vertex       int     16       vertex that is reached by `dock`; 0: none
    ~strategy          string  rolling  or vertex_by_vertex, direct, native
    ~native_command    string  (empty)  of strategy native: {goals} = names in order, {last}
    ~vertex_tolerance  float   0.3 m    a vertex is passed within this distance
    ~corridor_width    float   0.9 m    farther than half of it from the route, the route fails
    ~stall_timeout     float   30 s     without progress, the route fails
    ~location_timeout  float   5 s      without a location, the route fails
    ~link_timeout      float   2 s      without a link to the robot, the route fails
    ~top_speed         float   1.35 m/s
    ~acceleration      float   0.5 m/s2
    ~braking           float   0.2 m/s2, deceleration towards a goal
Uses ~route_record, a parameter of its own, to go on with a route after a restart.
"""
from __future__ import annotations

import threading
import time
from typing import Iterable, Optional

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from std_msgs.msg import String

from itrci_nav_msgs.msg import ExecutionRouteStates, TargetRoute
from itrci_nav_msgs.msg import Graph as GraphMessage
from omron_ld90.bridge import route_protocol as p
from omron_ld90.bridge.bridge_words import RobotWords, is_motion, status_events
from omron_ld90.bridge.report_schedule import TICK, ReportSchedule
from omron_ld90.bridge.route_follower import RouteFollower
from omron_ld90.bridge.route_settings import Settings
from omron_ld90.bridge.route_strategies import STRATEGIES
from omron_ld90.nodes.bridge_memory import RouteMemory
from omron_ld90.nodes.support import fleet_messages, shared_parameters, startup
from omron_ld90.nodes.support.diagnostics import publish_diagnostics
from omron_ld90.nodes.support.link_reports import words_of
from omron_ld90_msgs.msg import CommandRefused, LinkState, RobotStatus
from trajectory_graph import Graph, GraphError

RESTART = 20.0  # s after a restart in which the route that ran can be gone on with


class EdgesToVertices:
    """The node: see the module's text."""

    def __init__(self) -> None:
        graph = shared_parameters.trajectory_graph()
        self._lock = threading.RLock()
        self._follower = RouteFollower(
            _read_settings(graph), graph, links=(LinkState.COMMANDS, LinkState.OUTGOING))
        self._words = RobotWords()
        self._memory = RouteMemory()
        self._schedule = ReportSchedule()
        record = self._memory.recall()
        if record:
            self._follower.restore(record, time.monotonic() + RESTART)

        self._command = rospy.Publisher('send_command', String, queue_size=10, tcp_nodelay=True)
        self._states = rospy.Publisher('execution_route_states', ExecutionRouteStates,
                                       queue_size=10, latch=True, tcp_nodelay=True)
        for topic, kind, callback in (
                ('link_state', LinkState, self._on_link),
                ('robot_status', RobotStatus, self._on_status),
                ('arcl_response', String, self._on_line),
                ('command_refused', CommandRefused, self._on_refused),
                ('send_command', String, self._on_command),
                ('/graph', GraphMessage, self._on_graph),
                ('target_route', TargetRoute, self._on_route)):
            rospy.Subscriber(topic, kind, callback, queue_size=100, tcp_nodelay=True)
        self._timer = rospy.Timer(rospy.Duration(TICK), self._tick)
        publish_diagnostics('none', {'route': self._diagnose})
        if graph is None:
            rospy.logwarn('%s idles: ~graph_file is empty, and no /graph has come yet.',
                          rospy.get_name())

    def close(self) -> None:
        """Ends the timer."""
        self._timer.shutdown()

    # --- callbacks -------------------------------------------------------------------------------

    def _on_route(self, message: TargetRoute) -> None:
        self._handle([fleet_messages.order_of(message)])

    def _on_status(self, message: RobotStatus) -> None:
        self._handle(status_events(message))

    def _on_line(self, message: String) -> None:
        with self._lock:
            self._handle(self._words.line(message.data, time.monotonic()))

    def _on_link(self, message: LinkState) -> None:
        up = message.state == LinkState.CONNECTED
        reason = message.reason or words_of(message.state)
        self._handle([p.LinkChanged(message.link, up, '' if up else reason)])

    def _on_refused(self, message: CommandRefused) -> None:
        if message.caller == rospy.get_name():
            self._handle([p.CommandRefused(message.command, message.reason)])

    def _on_command(self, message: String) -> None:
        caller = message._connection_header['callerid']
        if caller != rospy.get_name() and is_motion(message.data):
            self._handle([p.ForeignCommand(message.data, caller)])

    def _on_graph(self, message: GraphMessage) -> None:
        try:
            graph = fleet_messages.graph_of(message)
        except GraphError as error:
            rospy.logerr('%s keeps its graph, because the one on /graph is not valid: %s',
                         rospy.get_name(), error)
            return
        with self._lock:
            self._act(self._follower.use_graph(graph, time.monotonic()))
        rospy.loginfo('The graph of /graph is used: %d vertices, %d edges.',
                      len(graph.vertices), len(graph.edges))

    def _tick(self, _event: Optional[rospy.timer.TimerEvent]) -> None:
        now = time.monotonic()
        with self._lock:
            self._handle(self._words.overdue(now))
            self._act(self._follower.tick(now))
            if self._schedule.is_due(self._follower.running, now):
                self._states.publish(fleet_messages.states_of(self._follower.report()))

    # --- actions ---------------------------------------------------------------------------------

    def _handle(self, events: Iterable[p.Event]) -> None:
        with self._lock:
            for event in events:
                self._act(self._follower.handle(event, time.monotonic()))

    def _act(self, actions: Iterable[p.Action]) -> None:
        for action in actions:
            if isinstance(action, p.Send):
                self._command.publish(String(action.command))
            elif isinstance(action, p.RouteReport):
                self._states.publish(fleet_messages.states_of(action))
            else:
                rospy.logwarn('%s', action.text)
        self._memory.keep(self._follower.record)

    def _diagnose(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        with self._lock:
            follower, report = self._follower, self._follower.report()
            route = follower.route
        if follower.graph is None:
            status.summary(DiagnosticStatus.WARN, 'Idle: there is no graph.')
        elif route is None:
            status.summary(DiagnosticStatus.OK, 'No route yet.')
        elif report.reason:
            status.summary(DiagnosticStatus.ERROR,
                           f'Route {report.route_id} failed: {report.reason}')
        else:
            status.summary(DiagnosticStatus.OK, f'Route {report.route_id}: {route.phase.value}')
        status.add('edges done', f'{list(report.states).count(p.EdgeState.COMPLETE)} of '
                                 f'{len(report.edges)}')
        status.add('edge', str(report.pose.edge))
        status.add('percentage', f'{report.pose.percentage:.1f}')
        status.add('going to', str(follower.robot.errand.goal))
        return status


def _read_settings(graph: Optional[Graph]) -> Settings:
    dock = startup.parameter('~dock_vertex', 16, int)
    if graph is not None and dock and dock not in graph.vertices:
        raise startup.ConfigurationError(
            f'~dock_vertex is {dock}, which is no vertex of the graph: set it to the id of the '
            'dock, or to 0 where there is none.')
    strategy = startup.choice('~strategy', 'rolling', tuple(STRATEGIES))
    native_command = startup.parameter('~native_command', '')
    if strategy == 'native':
        _check_native_command(native_command)
    return Settings(
        dock_vertex=dock or None,
        strategy=STRATEGIES[strategy],
        native_command=native_command if strategy == 'native' else '',
        vertex_tolerance=startup.number('~vertex_tolerance', 0.3, 0.05, 2.0),
        corridor_width=startup.number('~corridor_width', 0.9, 0.3, 10.0),
        stall_timeout=startup.number('~stall_timeout', 30.0, 1.0, 3600.0),
        location_timeout=startup.number('~location_timeout', 5.0, 0.5, 60.0),
        link_timeout=startup.number('~link_timeout', 2.0, 0.0, 60.0),
        top_speed=startup.number('~top_speed', 1.35, 0.1, 10.0),
        acceleration=startup.number('~acceleration', 0.5, 0.05, 10.0),
        braking=startup.number('~braking', 0.2, 0.05, 10.0))


def _check_native_command(template: str) -> None:
    try:
        wrong = '1 2' not in template.format(goals='1 2', last='1 2')
    except (LookupError, ValueError, AttributeError):
        wrong = True
    if wrong:
        raise startup.ConfigurationError(
            f'~native_command is {template!r}, but strategy native needs the command that takes '
            'several goals, with {goals} for their names or {last} for the last one.')


def main() -> None:
    """Runs the node."""
    startup.run('omron_edges_to_vertices', EdgesToVertices)
