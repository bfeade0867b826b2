"""path_supervisor: takes missions, gives each to a robot, and releases its route edge by edge.

It may be ended at any time: what was accepted, and what every robot may hold, is on the disk. See
docs/interface/path_supervisor.md and docs/fleet.md for its rules.

Subscribes
    /mission_request (itrci_nav_msgs/MissionRequest), /mission_command (MissionCommand)
    /graph, /closed_edges_in_force (latched, of graph_server), /plan_answer (of path_planner)
    /<robot>/execution_route_states, /<robot>/route_refused, of every robot in the fleet file
    /<robot>/battery_state (sensor_msgs/BatteryState), where there is one
Publishes
    /mission_status (itrci_nav_msgs/MissionStatus); the open ones again to who comes late
    /fleet_state (itrci_nav_msgs/FleetState), /fleet_plan (FleetPlan), both latched
    /plan_request (itrci_nav_msgs/PlanRequest), /<robot>/target_route (TargetRoute)
    /diagnostics
Services (std_srvs/Trigger)
    /stop_fleet, /resume_fleet; /<robot>/leave_fleet, /<robot>/join_fleet
Parameters
    ~fleet_file   string  (required)  fleet file (YAML)
    ~journal      string  graph_fleet_manager/fleet.sqlite in ROS_HOME
    ~improvement  float   0.0 s  in which the planner makes a plan better before it answers
    ~sim_speed    float   1.0    simulated robots are so many times faster
"""
from __future__ import annotations

import math
import os
import queue
import threading
import time
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import rospkg
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from sensor_msgs.msg import BatteryState
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from graph_fleet_manager.files.errors import FileError
from graph_fleet_manager.files.robot_settings import load_settings
from graph_fleet_manager.messages import missions as messages
from graph_fleet_manager.messages.planning import outcome_of, request_message
from graph_fleet_manager.nodes.fleet_parameter import fleet_of
from graph_fleet_manager.plan_requests import PlanRequest
from graph_fleet_manager.supervision.actions import (
    Action,
    AskPlanner,
    Note,
    SendRoute,
    TellStatus,
)
from graph_fleet_manager.supervision.fleet_view import RobotState, plan_views, robot_views
from graph_fleet_manager.supervision.journal import Journal, JournalError
from graph_fleet_manager.supervision.missions import (
    Command,
    MissionState,
    RequestRefused,
    Status,
)
from graph_fleet_manager.supervision.reports import WrongReport
from graph_fleet_manager.supervision.supervisor import Supervisor
from itrci_nav_msgs.msg import (
    ClosedEdges,
    ExecutionRouteStates,
    FleetPlan,
    FleetState,
    MissionCommand,
    MissionRequest,
    MissionStatus,
    PlanAnswer,
    RouteRefused,
    TargetRoute,
)
from itrci_nav_msgs.msg import Graph as GraphMessage
from itrci_nav_msgs.msg import PlanRequest as PlanRequestMessage
from node_lifecycle import ConfigurationError, number, parameter, publish_diagnostics, run
from trajectory_graph import Graph, GraphError
from trajectory_graph.messages import graph_from_message

TICK = 0.05       # s between two looks at the clock
VIEW_PERIOD = 0.5  # s between two /fleet_state, and the least between two /fleet_plan
_WAITING = 10000  # events, beyond which something is badly wrong
_SERVICE = 5.0    # s that a service call waits for its turn

Event = Callable[[Supervisor, float], Sequence[Action]]


class PathSupervisor:
    """See the module's text. One thread does everything; callbacks only leave it what came."""

    def __init__(self) -> None:
        self._fleet = fleet_of()
        try:
            self._settings = load_settings(parameter('~fleet_file'))
            self._journal = Journal(_journal_file())
        except (FileError, JournalError) as error:
            raise ConfigurationError(str(error)) from None
        self._improvement = number('~improvement', 0.0, 0.0, 10.0)
        self._rate = number('~sim_speed', 1.0, 0.01, 100.0)
        self._events: queue.Queue[Event] = queue.Queue(_WAITING)
        self._supervisor: Optional[Supervisor] = None
        self._graph: Optional[Graph] = None
        self._graph_stamp = rospy.Time(0)
        self._asked: Dict[int, rospy.Time] = {}
        self._route_stamps: Dict[str, rospy.Time] = {}
        self._viewed = -math.inf
        self._closed: Tuple[int, ...] = ()
        self._status_publisher = rospy.Publisher('/mission_status', MissionStatus,
                                                 subscriber_listener=_Newcomers(self._tell_open),
                                                 queue_size=1000)
        self._states = rospy.Publisher('/fleet_state', FleetState, queue_size=1, latch=True)
        self._plans = rospy.Publisher('/fleet_plan', FleetPlan, queue_size=1, latch=True)
        self._requests = rospy.Publisher('/plan_request', PlanRequestMessage, queue_size=10)
        self._routes = {robot.name: rospy.Publisher(f'/{robot.name}/target_route', TargetRoute,
                                                    queue_size=10, latch=False)
                        for robot in self._fleet.robots}
        self._thread = threading.Thread(target=self._work, name='supervisor', daemon=True)
        self._thread.start()
        publish_diagnostics('none', {'fleet': self._report_fleet,
                                     'missions': self._report_missions})
        self._subscribers = self._subscribe()
        self._services = self._serve()

    def _subscribe(self) -> List[rospy.Subscriber]:
        def listen(topic: str, kind: Any, handler: Callable[[Any], None],
                   waiting: int = 100) -> rospy.Subscriber:
            return rospy.Subscriber(topic, kind, handler, queue_size=waiting, tcp_nodelay=True)

        def of(name: str, handler: Callable[[str, Any], None]) -> Callable[[Any], None]:
            return lambda message: handler(name, message)

        subscribers = [
            listen('/graph', GraphMessage, self._on_graph, 1),
            listen('/closed_edges_in_force', ClosedEdges, self._on_closed, 1),
            listen('/mission_request', MissionRequest, self._on_request),
            listen('/mission_command', MissionCommand, self._on_command),
            listen('/plan_answer', PlanAnswer, self._on_answer)]
        for robot in self._routes:
            subscribers += [
                listen(f'/{robot}/execution_route_states', ExecutionRouteStates,
                       of(robot, self._on_report)),
                listen(f'/{robot}/route_refused', RouteRefused, of(robot, self._on_refusal)),
                listen(f'/{robot}/battery_state', BatteryState, of(robot, self._on_battery), 1)]
        return subscribers

    def _serve(self) -> List[rospy.Service]:
        services = [rospy.Service('/stop_fleet', Trigger, self._stop_fleet),
                    rospy.Service('/resume_fleet', Trigger, self._resume_fleet)]
        for robot in self._routes:
            services += [
                rospy.Service(f'/{robot}/leave_fleet', Trigger,
                              lambda _, name=robot: self._take_out(name)),
                rospy.Service(f'/{robot}/join_fleet', Trigger,
                              lambda _, name=robot: self._bring_in(name))]
        return services

    # -- the one thread ---------------------------------------------------------------------------

    def _work(self) -> None:
        due = time.monotonic()
        while not rospy.is_shutdown():
            try:
                event = self._events.get(timeout=max(due - time.monotonic(), 0.0))
            except queue.Empty:
                due = time.monotonic() + TICK
                event = Supervisor.tick
            supervisor = self._supervisor
            if supervisor is None:
                event = _nothing if event is Supervisor.tick else event
            try:
                self._do(event(supervisor, time.monotonic()))  # type: ignore[arg-type]
                self._publish_views()
            except JournalError as error:
                rospy.logfatal('%s The robots go on with what they were given; this node ends.',
                               error)
                os._exit(1)

    def _put(self, event: Event) -> None:
        """Leaves an event to the thread; without a graph there is nobody who understands it."""
        def when_ready(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            return () if supervisor is None else event(supervisor, now)
        self._events.put(when_ready)

    def _do(self, actions: Sequence[Action]) -> None:
        for action in actions:
            if isinstance(action, SendRoute):
                if not action.repeated or action.robot not in self._route_stamps:
                    self._route_stamps[action.robot] = rospy.Time.now()
                self._routes[action.robot].publish(messages.route_message(
                    action.route_id, action.edges, self._route_stamps[action.robot]))
            elif isinstance(action, TellStatus):
                self._tell(action.status)
            elif isinstance(action, AskPlanner):
                self._ask(action)
            elif isinstance(action, Note):
                (rospy.logwarn if action.is_warning else rospy.loginfo)('%s', action.text)

    def _tell(self, status: Status) -> None:
        self._status_publisher.publish(messages.status_message(status, rospy.Time.now()))

    def _tell_open(self, publish: Callable[[MissionStatus], None]) -> None:
        def tell(supervisor: Supervisor, now: float) -> Sequence[Action]:
            for status in supervisor.open_statuses():
                publish(messages.status_message(status, rospy.Time.now()))
            return ()
        self._put(tell)

    def _ask(self, question: AskPlanner) -> None:
        stamp = rospy.Time.now()
        self._asked = {question.number: stamp}
        self._requests.publish(request_message(
            PlanRequest(question.tasks, question.obstacles, question.closed, time_limit=0.0,
                        improvement=self._improvement),
            question.number, stamp, self._graph_stamp, self._rate))

    def _publish_views(self) -> None:
        supervisor, now = self._supervisor, time.monotonic()
        if supervisor is None or now - self._viewed < VIEW_PERIOD:
            return
        self._viewed = now
        stamp = rospy.Time.now()

        def moment(seconds: float) -> rospy.Time:
            return max(stamp + rospy.Duration.from_sec(seconds - now), rospy.Time(0))
        self._states.publish(messages.state_message(robot_views(supervisor, now), moment, stamp))

        def planned(seconds: float) -> rospy.Time:
            plan = supervisor.plan
            made_at = plan.made_at if plan else now
            return moment(made_at + (seconds - made_at) / self._rate)
        self._plans.publish(messages.plan_message(plan_views(supervisor), planned, stamp))

    # -- what comes in ----------------------------------------------------------------------------

    def _on_graph(self, message: GraphMessage) -> None:
        try:
            graph = graph_from_message(message)
        except GraphError as error:
            rospy.logerr('The graph on /graph is not valid, the one before stays: %s', error)
            return
        self._events.put(lambda supervisor, now: self._use_graph(graph, message.header.stamp, now))

    def _use_graph(self, graph: Graph, stamp: rospy.Time, now: float) -> Sequence[Action]:
        self._graph_stamp = stamp
        before, self._graph = self._graph, graph
        if before is not None and (before.vertices, before.edges) == (graph.vertices, graph.edges):
            return ()
        # A graph is as good as a restart: everything that matters is in the journal, and
        # graph_server has seen to it that no robot's route breaks.
        self._supervisor = Supervisor(graph, self._fleet, self._settings, self._journal, now)
        return self._supervisor.close_edges(self._closed, now)

    def _on_closed(self, message: ClosedEdges) -> None:
        edges = tuple(message.edges)

        def close(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            self._closed = edges
            return () if supervisor is None else supervisor.close_edges(edges, now)
        self._events.put(close)

    def _on_request(self, message: MissionRequest) -> None:
        def take(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            try:
                request = messages.request_of(message)
                if supervisor is None:
                    raise RequestRefused('the fleet manager has no graph yet; try again')
            except RequestRefused as refused:
                return (TellStatus(Status(message.request_id, MissionState.REFUSED,
                                          reason=str(refused))),)
            return supervisor.request(request, now)
        self._events.put(take)

    def _on_command(self, message: MissionCommand) -> None:
        try:
            command = Command(message.command)
        except ValueError:
            rospy.logwarn('A mission command %d for mission %d is ignored: there is no such '
                          'command.', message.command, message.request_id)
            return
        self._put(lambda supervisor, now: supervisor.command(message.request_id, command, now))

    def _on_report(self, robot: str, message: ExecutionRouteStates) -> None:
        try:
            report = messages.report_of(message, rospy.Time.now())
        except WrongReport as wrong:
            rospy.logwarn_throttle(10.0, f'A report of {robot} is ignored: {wrong}.')
            return
        self._put(lambda supervisor, now: supervisor.report(robot, report, now))

    def _on_refusal(self, robot: str, message: RouteRefused) -> None:
        refusal = messages.refusal_of(message)
        self._put(lambda supervisor, now: supervisor.refusal(robot, refusal, now))

    def _on_battery(self, robot: str, message: BatteryState) -> None:
        charge = message.percentage
        if 0.0 <= charge <= 1.0:
            self._put(lambda supervisor, now: supervisor.battery(robot, charge, now))

    def _on_answer(self, message: PlanAnswer) -> None:
        def take(supervisor: Supervisor, now: float) -> Sequence[Action]:
            if self._asked.get(message.plan_id) != message.header.stamp:
                return ()
            if message.result == PlanAnswer.PLANNED:
                return supervisor.plan_made(message.plan_id, outcome_of(message, self._rate), now)
            return supervisor.plan_failed(message.plan_id, message.reason.rstrip('.'), now)
        self._put(take)

    # -- services ---------------------------------------------------------------------------------

    def _stop_fleet(self, _: TriggerRequest) -> TriggerResponse:
        return self._call(lambda supervisor, now: ('', supervisor.stop_fleet(now)),
                          'Every robot was told to stop.')

    def _resume_fleet(self, _: TriggerRequest) -> TriggerResponse:
        def resume(supervisor: Supervisor, now: float) -> Tuple[str, Sequence[Action]]:
            problems, actions = supervisor.resume_fleet(now)
            return '; '.join(problems), actions
        return self._call(resume, 'The fleet goes on.')

    def _take_out(self, name: str) -> TriggerResponse:
        return self._call(lambda supervisor, now: ('', supervisor.take_out(name, now)),
                          f'{name} was told to stop and is out of service.')

    def _bring_in(self, name: str) -> TriggerResponse:
        return self._call(lambda supervisor, now: supervisor.bring_in(name, now),
                          f'{name} is in service.')

    def _call(self, act: Callable[[Supervisor, float], Tuple[str, Sequence[Action]]],
              done: str) -> TriggerResponse:
        """Has the thread do something and answers with what became of it."""
        answer: queue.Queue[TriggerResponse] = queue.Queue(1)

        def event(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            if supervisor is None:
                answer.put(TriggerResponse(False, 'the fleet manager has no graph yet'))
                return ()
            problem, actions = act(supervisor, now)
            answer.put(TriggerResponse(not problem, problem or done))
            return actions
        self._events.put(event)
        try:
            return answer.get(timeout=_SERVICE)
        except queue.Empty:
            return TriggerResponse(False, f'not done within {_SERVICE:.0f} s')

    # -- diagnostics ------------------------------------------------------------------------------

    def _report_fleet(self, status: DiagnosticStatusWrapper) -> None:
        supervisor = self._supervisor
        if supervisor is None:
            status.summary(DiagnosticStatus.WARN, 'waiting for /graph')
            return
        views = robot_views(supervisor, time.monotonic())
        out = [view for view in views if view.state >= RobotState.OFFLINE]
        if supervisor.is_stopped:
            status.summary(DiagnosticStatus.WARN, 'the fleet is stopped')
        elif out:
            status.summary(DiagnosticStatus.WARN,
                           f'{len(out)} of {len(views)} robots cannot work')
        else:
            status.summary(DiagnosticStatus.OK, f'{len(views)} robots')
        for view in views:
            waits = f': {view.waits_for}' if view.waits_for else ''
            status.add(view.name, f'{view.state.name}{waits}')

    def _report_missions(self, status: DiagnosticStatusWrapper) -> None:
        supervisor = self._supervisor
        states = [] if supervisor is None else [s.state for s in supervisor.open_statuses()]
        status.summary(DiagnosticStatus.OK, f'{len(states)} open missions')
        for state in (MissionState.PENDING, MissionState.ACTIVE, MissionState.PAUSED):
            status.add(state.name, str(states.count(state)))


class _Newcomers(rospy.SubscribeListener):  # type: ignore[misc]  # rospy has no types
    """Calls `tell(publish)` for every new subscriber."""

    def __init__(self, tell: Callable[[Callable[[MissionStatus], None]], None]) -> None:
        super().__init__()
        self._new = tell

    def peer_subscribe(self, topic_name: str, topic_publish: Callable[[Any], None],
                       peer_publish: Callable[[Any], None]) -> None:
        self._new(peer_publish)


def _nothing(supervisor: Supervisor, now: float) -> Sequence[Action]:
    return ()


def _journal_file() -> str:
    path: str = parameter('~journal', '')
    path = path or os.path.join(rospkg.get_ros_home(), 'graph_fleet_manager', 'fleet.sqlite')
    try:
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    except OSError as error:
        raise ConfigurationError(f'The folder of the journal {path} cannot be made '
                                 f'({error.strerror}); choose another with ~journal.') from None
    return path


def main() -> None:
    """Runs the node."""
    run('path_supervisor', PathSupervisor)
