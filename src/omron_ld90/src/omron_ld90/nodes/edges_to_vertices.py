"""The bridge between the fleet manager, which uses edges, and the LD-90, which uses goals.

The node takes routes of edges, sends the robot over their vertices, and reports the progress, as
docs/reference/route_protocol.md says. `omron_ld90.bridge.route_follower` makes the decisions.

Subscribes
    target_route (itrci_nav_msgs/TargetRoute): the route to drive
    /graph (itrci_nav_msgs/Graph): replaces the graph of ~graph_file
    robot_status (omron_ld90_msgs/RobotStatus), link_state (omron_ld90_msgs/LinkState)
    motion (omron_ld90_msgs/Motion): giver that drives the robot; if another giver drives it, the
        route ends
Publishes
    execution_route_states (itrci_nav_msgs/ExecutionRouteStates, latched): 10 Hz and on change
        while a route runs, otherwise 1 Hz
    route_refused (itrci_nav_msgs/RouteRefused): a route, or a change of it, that was refused
    /diagnostics
Client of
    execute_command (omron_ld90_msgs/ExecuteCommand): goto, dock, stop
Parameters
    ~graph_file        string  (empty)  trajectory graph (YAML); empty: wait for /graph
    ~dock_vertex       int     0        vertex that is reached with `dock`; 0: none
    ~strategy          string  rolling  or vertex_by_vertex, direct, native
    ~native_command    string  (empty)  for strategy native: {goals} = names in order, {last}
    ~vertex_tolerance  float   0.3 m    a vertex is passed within this distance
    ~corridor_width    float   0.9 m    the route fails if the robot is more than half of this width
                                        away from its edge
    ~stall_timeout     float   30 s     the route fails after this time without progress
    ~location_timeout  float   5 s      the route fails after this time without a location
    ~link_timeout      float   2 s      the route fails after this time without a link to the robot
    ~restart_timeout   float   20 s     the route fails if omron_controller, the receiver or this
                                        node is gone for longer
    ~top_speed         float   1.35 m/s
    ~acceleration      float   0.5 m/s2
    ~braking           float   0.2 m/s2, deceleration towards a goal
    ~launch_id         string  (empty)  id of the launch; a route of an earlier launch is not
                                        continued if a person has ended that launch
    ~route_file        string  (empty)  file that keeps the route when the ROS master ends, until
                                        the next boot; a relative path begins in ROS_HOME
The node keeps the route in its private parameter ~route_record, to continue it after a restart.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Dict, Iterable, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from graph_topic import FollowedGraph
from itrci_nav_msgs import msg
from node_lifecycle import parameter, publish_diagnostics, run
from node_lifecycle.event_loop import EventLoop
from node_lifecycle.worker import start_worker
from omron_ld90.bridge import events as p
from omron_ld90.bridge.route_follower import RouteFollower
from omron_ld90.bridge.running_clock import RunningClock
from omron_ld90.nodes.bridge_memory import PARAMETER, RouteMemory
from omron_ld90.nodes.bridge_messages import (
    command_ended,
    link_reported,
    motion_told,
    robot_seen,
)
from omron_ld90.nodes.bridge_settings import read_settings
from omron_ld90.nodes.support import shared_parameters
from omron_ld90.nodes.support.command_client import CommandClient
from omron_ld90.nodes.support.old_messages import OldMessages, publishers_by_master
from omron_ld90_msgs.msg import (
    ExecuteCommandResult,
    LinkState,
    Motion,
    RobotStatus,
)
from route_protocol.messages import fill_refusal, fill_report, order_of
from route_protocol.values import RouteRefusal, RouteReport
from trajectory_graph import Graph

TICK = 0.1          # s between two steps of the follower, and between reports of a running route
IDLE_PERIOD = 1.0   # s between two reports without a route
QUEUE_SIZE = 1000   # events; if the queue is full, the topics wait and drop their oldest messages

Diagnosis = Tuple[bytes, str, Dict[str, str]]  # level, summary and values


class EdgesToVertices:
    """The node: see the module's text.

    One thread owns the follower and calls rospy and actionlib. Callbacks only queue events for this
    thread, so the follower needs no lock.

    The class has many attributes because it connects the parts of the node.
    """

    def __init__(self) -> None:
        graph = shared_parameters.trajectory_graph()
        self._clock = RunningClock()
        settings = read_settings(graph)
        self._follower = RouteFollower(settings, graph, links=tuple(p.RobotLink))
        self._memory = RouteMemory(parameter('~launch_id', ''), parameter('~route_file', ''))
        self._memory.hold()
        left = self._memory.recall()
        if left is not None:
            self._follower.restore(left.record, left.age < settings.restart_timeout,
                                   self._clock.read(), left.is_sure)
        self._loop = EventLoop(self._tick, TICK)
        self._reported = self._diagnosed = -IDLE_PERIOD
        self._diagnosis: Diagnosis = (DiagnosticStatus.WARN, 'starting', {})

        self._states = rospy.Publisher('execution_route_states', msg.ExecutionRouteStates,
                                       queue_size=10, latch=True, tcp_nodelay=True)
        self._refusals = rospy.Publisher('route_refused', msg.RouteRefused, queue_size=10,
                                         tcp_nodelay=True)
        self._commands = CommandClient(self._on_end, numbers_grow=True)
        self._old = OldMessages(publishers_by_master)
        self._old.watch('target_route')
        for topic, kind, callback in (
                ('link_state', LinkState, self._on_link),
                ('robot_status', RobotStatus, self._on_status),
                ('motion', Motion, self._on_motion),
                ('target_route', msg.TargetRoute, self._on_route)):
            rospy.Subscriber(topic, kind, callback, queue_size=100, tcp_nodelay=True)
        FollowedGraph(self._on_graph, graph).subscribe()
        publish_diagnostics('none', {'route': self._diagnose})
        self._thread = start_worker('route-follower', self._loop.run)
        if graph is None:
            rospy.logwarn('%s idles: ~graph_file is empty, and no /graph has come yet.',
                          rospy.get_name())

    def close(self) -> None:
        """Ends the threads."""
        self._loop.end()
        self._thread.join(0.5)
        self._memory.close()

    # --- callbacks -------------------------------------------------------------------------------

    def _on_event(self, event: p.Event) -> None:
        """Queues an event from a topic. Waits while the queue is full; then the topic drops its
        oldest messages.
        """
        self._loop.put_if_room(
            lambda: self._act(self._follower.handle(event, self._clock.read())), QUEUE_SIZE,
            lambda: rospy.logwarn_throttle(10.0, '%s cannot keep up with its topics.',
                                           rospy.get_name()))

    def _on_end(self, number: int, result: ExecuteCommandResult) -> None:
        event = command_ended(number, result)
        self._loop.put(lambda: self._act(self._follower.handle(event, self._clock.read())))

    def _on_route(self, message: msg.TargetRoute) -> None:
        self._on_event(replace(order_of(message, rospy.Time.now().to_nsec()),
                           comes_again=self._old.comes_again(message, 'target_route')))

    def _on_status(self, message: RobotStatus) -> None:
        self._on_event(robot_seen(message))

    def _on_link(self, message: LinkState) -> None:
        event = link_reported(message)
        if event is not None:
            self._on_event(event)

    def _on_motion(self, message: Motion) -> None:
        self._on_event(motion_told(message, rospy.get_name()))

    def _on_graph(self, graph: Graph, _stamp: rospy.Time) -> None:
        self._loop.put(lambda: self._act(self._follower.use_graph(graph, self._clock.read())))
        rospy.loginfo('A new graph has arrived on /graph: %d vertices, %d edges.',
                      len(graph.vertices), len(graph.edges))

    # --- the thread that owns the follower -------------------------------------------------------

    def _tick(self) -> None:
        now = self._clock.read()
        self._commands.check()
        self._act(self._follower.tick(now))
        if now - self._diagnosed >= IDLE_PERIOD:
            self._diagnosed = now
            self._diagnosis = _diagnosis(self._follower, now)
        period = TICK if self._follower.running else IDLE_PERIOD
        if now - self._reported >= period - TICK / 2.0:
            self._reported = now
            self._report(self._follower.report())

    def _act(self, actions: Iterable[p.Action]) -> None:
        self._memory.keep(self._follower.record)  # the record is kept before the robot acts
        for action in actions:
            if isinstance(action, p.Give):
                self._commands.give(action.number, action.command, action.known_epoch)
            elif isinstance(action, RouteReport):
                self._report(action)
            elif isinstance(action, RouteRefusal):
                self._refusals.publish(fill_refusal(msg.RouteRefused(), action,
                                                    rospy.Time.now().to_nsec()))
            else:
                rospy.logwarn('%s', action.text)

    def _report(self, report: RouteReport) -> None:
        self._states.publish(fill_report(msg.ExecutionRouteStates(), report, msg.EdgeState))

    def _diagnose(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        level, summary, values = self._diagnosis
        status.summary(level, summary)
        for name, value in values.items():
            status.add(name, value)
        return status


def _diagnosis(follower: RouteFollower, now: float) -> Diagnosis:
    """Returns the content of the diagnostic `route`."""
    state, reason, pose = follower.vehicle.state, follower.reason, follower.pose
    robot = follower.robot
    unknown = robot.why_unknown(now)
    if robot.stop_problem:
        level, summary = DiagnosticStatus.ERROR, (
            f'The robot has not obeyed a stop yet: {robot.stop_problem}')
    elif follower.graph is None:
        level, summary = DiagnosticStatus.WARN, 'Idle: there is no graph.'
    elif reason:
        level, summary = DiagnosticStatus.ERROR, f'Route {state.route_id} failed: {reason}'
    else:
        level = DiagnosticStatus.WARN if unknown else DiagnosticStatus.OK
        summary = (f'Route {state.route_id}: {state.phase.value}' if state.order or state.edges
                   else 'No route yet.')
        if unknown:
            summary = f'{summary.rstrip(".")}. The robot cannot be driven now: {unknown}'
    return level, summary, {
        'edges done': f'{state.completed} of {len(state.edges)}',
        'edge': str(pose.edge), 'percentage': f'{pose.percentage:.1f}',
        'motion': follower.motion.name, 'order': str(state.order),
        'going to': str(robot.tracker.goal), 'command': robot.tracker.word.command}


def main() -> None:
    """Runs the node."""
    run('omron_edges_to_vertices', EdgesToVertices, written=(PARAMETER,))
