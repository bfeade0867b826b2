"""path_supervisor: accepts missions, gives each to a robot, and releases its route edge by edge.

It may be ended at any time, because the accepted missions and the allocations of all robots are on
the disk. While nothing can be written to the disk, it waits and sends only stops. Its rules are in
docs/reference/path_supervisor.md and docs/explanation/fleet.md.

Subscribes
    /mission_request (itrci_nav_msgs/MissionRequest), /mission_command (MissionCommand)
    /graph, /closed_edges_in_force (latched, of graph_server), /plan_answer (of path_planner)
    /<robot>/execution_route_states, of every robot in the fleet file
    /<robot>/battery_state (sensor_msgs/BatteryState), if the robot has that topic
    /<robot>/step_states (itrci_nav_msgs/StepStates), if the robot carries out steps
    /devices/<device>/step_states (StepStates), for each machine of the work file
    /device_states (itrci_nav_msgs/DeviceState), of fleet_devices
Publishes
    /mission_status (itrci_nav_msgs/MissionStatus); a new subscriber gets all open missions
    /fleet_state (itrci_nav_msgs/FleetState), /fleet_plan (FleetPlan), both latched
    /mission_templates (itrci_nav_msgs/MissionTemplates), /timetables (Timetables), latched: the
    templates and the timetables of the work file
    /fleet_poses (itrci_nav_msgs/FleetPoses), 5 Hz
    /fleet_allocations (itrci_nav_msgs/FleetAllocations), twice a second while a program subscribes
    /plan_request (itrci_nav_msgs/PlanRequest), /<robot>/target_route (TargetRoute),
    /<robot>/step_command (StepCommand), /device_request (DeviceRequest)
    /devices/<device>/step_command (StepCommand), for each machine of the work file
    /diagnostics
Services (std_srvs/Trigger)
    /stop_fleet, /resume_fleet; /<robot>/leave_fleet, /<robot>/join_fleet; /<robot>/declare_absent,
    also for robots that are not in the fleet file any more
    /get_mission_status (itrci_nav_msgs/GetMissionStatus): the stored status of a mission
    /explain_mission (itrci_nav_msgs/ExplainMission): what an open mission waits for
    /<robot>/set_load (itrci_nav_msgs/SetLoad): a person says what a robot carries
    /<robot>/charge (itrci_nav_msgs/ChargeRobot): a robot is asked to charge
    /pause_timetable (itrci_nav_msgs/PauseTimetable): a timetable is paused, or goes on
Parameters
    ~fleet_file   string  (required)  fleet file (YAML)
    ~work_file    string  (none)     work file (YAML) of stations, devices, templates, timetables
    ~journal      string  graph_fleet_manager/fleet.sqlite in ROS_HOME
    ~keep_days    float   90.0   days for which the journal keeps missions that have ended
    ~improvement  float   0.0 s  time in which the planner improves a plan before it answers
    ~order_switching bool  false  true: robots that wait for a late robot may go before it
    ~check_every     int   0      events between two checks against the model of allocations; 0: no
                                  check
    ~sim_speed    float   1.0    factor by which simulated robots are faster
"""
from __future__ import annotations

import math
import os
import threading
import time
import traceback
from functools import partial
from typing import Any, Callable, Iterable, List, Optional, Sequence, Tuple, Union

import rosgraph
import rospy
from rospy.impl.registration import get_service_manager
from sensor_msgs.msg import BatteryState

from fleet_core.files.errors import FileError
from fleet_core.files.robot_settings import load_settings
from fleet_core.interlocking.conformance import Conformance
from fleet_core.interlocking.stop_gate import StopGate
from fleet_core.supervision.actions import Action, PublishStatus
from fleet_core.supervision.early_stop import EarlyStop
from fleet_core.supervision.fleet_stop import FleetStop
from fleet_core.supervision.fleet_view import FleetView, fleet_view
from fleet_core.supervision.journal_database import JournalUnavailable
from fleet_core.supervision.missions import CommandKind, MissionChange, RequestRefused, StepAnswer
from fleet_core.supervision.outbox import AGAIN
from fleet_core.supervision.supervisor import Supervisor
from fleet_core.supervision.switching import OrderSwitching
from graph_fleet_manager.commands import stop_address
from graph_fleet_manager.messages import missions as messages
from graph_fleet_manager.messages.planning import WrongAnswer, outcome_of
from graph_fleet_manager.messages.stops import WrongStopMessage, answer_of, stops_of
from graph_fleet_manager.nodes.event_loop import SupervisorEvents
from graph_fleet_manager.nodes.fleet_diagnosis import report_fleet, report_missions
from graph_fleet_manager.nodes.fleet_parameter import fleet_of
from graph_fleet_manager.nodes.fleet_poses import FleetPosesTopic
from graph_fleet_manager.nodes.fleet_services import FleetServices, not_stored
from graph_fleet_manager.nodes.fleet_topics import FleetTopics, PublishStatuses, status_message
from graph_fleet_manager.nodes.journal_file import JournalFile
from graph_fleet_manager.nodes.sending import send
from graph_fleet_manager.nodes.work_file import WorkFile
from graph_topic import FollowedGraph
from itrci_nav_msgs.msg import (
    ClosedEdges,
    DeviceState,
    ExecutionRouteStates,
    MissionCommand,
    MissionRequest,
    PlanAnswer,
    StepStates,
)
from node_lifecycle import ConfigurationError, number, parameter, publish_diagnostics, run
from node_lifecycle.measurements import measured
from route_protocol.device_messages import WrongDeviceMessage, device_report_of
from route_protocol.messages import WrongReport, software_of
from route_protocol.step_messages import WrongStepMessage, step_report_of
from route_protocol.steps import StepReport
from trajectory_graph import Graph

VIEW_PERIOD = 0.5  # s between two /fleet_state, and the least time between two /fleet_plan


class PathSupervisor:
    """The node; see the docstring of the module. One thread decides; callbacks only queue events.

    It connects many parts, so it has many attributes.
    """

    def __init__(self) -> None:
        self._fleet = fleet_of()
        try:
            self._settings = load_settings(parameter('~fleet_file'))
        except FileError as error:
            raise ConfigurationError(str(error)) from None
        self._work_file = WorkFile(self._fleet)
        self._file = JournalFile()
        self._rate = number('~sim_speed', 1.0, 0.01, 100.0)
        self._switches: bool = parameter('~order_switching', False, bool)
        self._check_every = int(number('~check_every', 0, 0))
        self._events = SupervisorEvents(trouble=lambda: self._file.trouble)
        self._supervisor: Optional[Supervisor] = None
        self._graph: Optional[Graph] = None
        self._begin_at = math.inf
        self._view: Optional[FleetView] = None
        """The newest view, which other threads read. None: there is no supervisor."""
        self._viewed = -math.inf
        self._closed: Optional[Tuple[int, ...]] = None
        robots = [robot.name for robot in self._fleet.robots]
        self._early = EarlyStop(robots)
        self._gate = StopGate()
        self._device_subscribers: List[rospy.Subscriber] = []
        self._topics = FleetTopics(robots, self._rate, number('~improvement', 0.0, 0.0, 10.0),
                                   self._publish_open, self._gate)
        self._poses = FleetPosesTopic(robots)
        self._services = FleetServices(
            robots, self._gate, self._events, self._stop_early,
            lambda now, stop: self._topics.do(EarlyStop(robots).stop(now, stop)))
        _note_stop_address()
        self._thread = threading.Thread(target=self._work, name='supervisor', daemon=True)
        self._thread.start()
        publish_diagnostics('none', {
            'fleet': lambda status: report_fleet(
                self._view, self._file.trouble or self._work_file.trouble, status),
            'missions': lambda status: report_missions(self._supervisor, status)})
        self._subscribers = self._subscribe(robots)

    def _subscribe(self, robots: Iterable[str]) -> List[rospy.Subscriber]:
        def listen(topic: str, kind: Any, handler: Callable[[Any], None],
                   waiting: Optional[int] = 100) -> rospy.Subscriber:
            return rospy.Subscriber(topic, kind, handler, queue_size=waiting, tcp_nodelay=True)

        def of(name: str, handler: Callable[[str, Any], None]) -> Callable[[Any], None]:
            return lambda message: handler(name, message)

        subscribers = [
            FollowedGraph(self._on_graph, each=True).subscribe(),
            listen('/closed_edges_in_force', ClosedEdges, self._on_closed, 1),
            listen('/mission_request', MissionRequest, self._on_request, None),
            listen('/mission_command', MissionCommand, self._on_command, None),
            listen('/plan_answer', PlanAnswer, self._on_answer),
            listen('/device_states', DeviceState, self._on_device, 1000)]
        for robot in robots:
            subscribers += [
                listen(f'/{robot}/execution_route_states', ExecutionRouteStates,
                       of(robot, self._on_report)),
                listen(f'/{robot}/battery_state', BatteryState, of(robot, self._on_battery), 1),
                listen(f'/{robot}/step_states', StepStates, of(robot, self._on_steps))]
        return subscribers

    # -- the thread that decides ------------------------------------------------------------------

    def _work(self) -> None:
        while not rospy.is_shutdown():
            event = self._events.next_event()
            try:
                self._topics.do(event(self._supervisor, time.monotonic()))
                self._topics.do(self._begin(time.monotonic()))
                if self._supervisor is not None:
                    self._events.hurry(self._supervisor.tick_due)
                self._publish_views()
                self._file.forget(time.monotonic())
            except Exception:  # a fleet manager that cannot decide must not seem to work
                try:
                    rospy.logfatal('A defect: this node ends, to be started again. The robots '
                                   'drive on along the edges that were released.\n%s',
                                   traceback.format_exc())
                finally:
                    os._exit(1)

    def _stop_early(self, now: float, stop: FleetStop) -> Tuple[str, Sequence[Action]]:
        """Stops all robots while there is no supervisor. Returns a warning and the orders."""
        trouble = self._file.trouble
        try:
            journal = self._file.journal
            if journal is not None and not journal.stop().is_in_force:
                journal.store(stop=stop)
        except JournalUnavailable as unavailable:
            trouble = unavailable.reason
        return f' {not_stored(trouble)}' if trouble else '', self._early.stop(now, stop)

    def _publish_open(self, publish: PublishStatuses) -> None:
        def statuses_to_publish(supervisor: Supervisor, now: float) -> Sequence[Action]:
            for status in supervisor.book.stored_open:
                send(publish, status_message(status))
            return ()
        self._events.put_order(statuses_to_publish)

    def _publish_views(self) -> None:
        supervisor, now = self._supervisor, time.monotonic()
        if supervisor is None or now - self._viewed < VIEW_PERIOD:
            return
        self._viewed = now
        self._view = fleet_view(supervisor, now)
        self._topics.publish_views(supervisor, self._view, now)

    # -- callbacks --------------------------------------------------------------------------------

    def _on_graph(self, graph: Graph, stamp: rospy.Time) -> None:
        self._events.put(lambda supervisor, now: self._use_graph(graph, stamp, now))

    def _use_graph(self, graph: Graph, stamp: rospy.Time, now: float) -> Sequence[Action]:
        self._topics.graph_stamp = stamp
        before, self._graph = self._graph, graph
        if graph is before:  # only the stamp is new: the same graph was published again
            return ()
        self._begin_at = now
        return ()

    def _on_closed(self, message: ClosedEdges) -> None:
        edges = tuple(message.edges)

        def close(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            self._closed = edges
            return () if supervisor is None else supervisor.close_edges(edges, now)
        self._events.put(close)

    def _begin(self, now: float) -> Sequence[Action]:
        """Begins to supervise if that is due and there are a graph, closed edges and a journal.

        A new graph has the same effect as a restart: the old supervisor ends, and a new one begins
        from the journal. So nothing is granted according to the old graph. graph_server has
        checked that the new graph contains the routes of all robots.
        """
        self._file.open(now)
        journal = self._file.journal
        waiting = () if self._supervisor is not None else self._early.due(now)
        if self._graph is None or self._closed is None or journal is None or (
                now < self._begin_at or (self._supervisor and self._supervisor.trouble)):
            return waiting
        self._supervisor, self._begin_at = None, now + AGAIN
        self._view, self._viewed = None, -math.inf
        self._events.end()
        work = self._work_file.read(self._graph)
        if work is None:
            return waiting
        try:
            switching = OrderSwitching(self._fleet.clearance) if self._switches else None
            supervisor = Supervisor(self._graph, self._fleet, self._settings, journal, now,
                                    self._rate, self._gate, switching,
                                    Conformance(self._check_every) if self._check_every else None,
                                    work=work)
        except JournalUnavailable as unavailable:
            self._file.fail(unavailable)
            return waiting
        self._file.mended()
        self._begin_at = math.inf
        self._supervisor = supervisor
        self._services.offer_removed(supervisor.removed)
        self._topics.publish_templates(work)
        self._topics.begin_devices(work.step_devices)
        self._listen_to_devices(work.step_devices)
        stop = self._early.hand_over()
        is_stopped = stop or (self._gate.is_closed and not supervisor.is_stopped)
        stopping = supervisor.stop_fleet(now, stop) if is_stopped else ()
        self._events.begin()
        return [*stopping, *supervisor.close_edges(self._closed, now)]

    def _on_request(self, message: MissionRequest) -> None:
        try:
            request = messages.request_of(message)
        except RequestRefused as refused:
            refusal = PublishStatus(messages.refusal_status(message, str(refused)))
            self._events.put(lambda supervisor, now: (refusal,))
            return
        self._events.put_request(request)

    def _on_command(self, message: MissionCommand) -> None:
        try:
            command = CommandKind(message.command)
        except ValueError:
            rospy.logwarn('A mission command %d for mission %d is ignored: there is no such '
                          'command.', message.command, message.request_id)
            return
        details: Union[None, MissionChange, StepAnswer] = None
        try:
            if command is CommandKind.MODIFY:
                details = MissionChange(message.priority, tuple(message.destination_vertices_id),
                                        stops_of(message.stops), message.first_stop)
            elif command is CommandKind.ANSWER:
                details = answer_of(message)
        except WrongStopMessage as wrong:
            rospy.logwarn('%s of mission %d is ignored: %s.', command.name, message.request_id,
                          wrong)
            return
        self._events.put_command(message.request_id, command, details,
                                 messages.person_of(message.requested_by))

    def _on_report(self, robot: str, message: ExecutionRouteStates) -> None:
        try:
            report = messages.report_of(message, rospy.Time.now())
        except WrongReport as wrong:
            rospy.logwarn_throttle(10.0, f'A report of {robot} is ignored: {wrong}.')
            return
        self._poses.note(robot, message)
        self._topics.software[robot] = software_of(message)
        self._events.put_report(
            lambda supervisor, now, arrived: supervisor.report(robot, report, now, arrived),
            f'/{robot}/execution_route_states')

    def _on_steps(self, robot: str, message: StepStates) -> None:
        report = _step_report(robot, message)
        if report is not None:
            self._events.put_report(
                lambda supervisor, now, _: supervisor.step_report(robot, report, now),
                f'/{robot}/step_states')

    def _on_device_steps(self, device: str, message: StepStates) -> None:
        report = _step_report(f'device {device}', message)
        if report is not None:
            self._events.put_report(
                lambda supervisor, now, _: supervisor.device_steps(device, report, now),
                f'/devices/{device}/step_states')

    def _listen_to_devices(self, devices: Iterable[str]) -> None:
        """Subscribes to the steps of these devices only. The new subscriptions receive the latched
        reports again.
        """
        for subscriber in self._device_subscribers:
            subscriber.unregister()
        self._device_subscribers = [
            rospy.Subscriber(f'/devices/{name}/step_states', StepStates,
                             partial(self._on_device_steps, name), queue_size=100,
                             tcp_nodelay=True) for name in devices]

    def _on_device(self, message: DeviceState) -> None:
        try:
            report = device_report_of(message)
        except WrongDeviceMessage as wrong:
            rospy.logwarn_throttle(10.0, f'A report of a device is ignored: {wrong}.')
            return
        ahead = time.monotonic() - rospy.get_time()  # s, supervisor's clock minus ROS time
        report = report.at(report.since + ahead,
                           None if report.read_at is None else report.read_at + ahead)
        self._events.put_report(
            lambda supervisor, now, _: supervisor.device_report(report, now),
            f'/device_states/{report.device}')

    def _on_battery(self, robot: str, message: BatteryState) -> None:
        charge = measured(message.percentage, 0.0, 1.0, f'The charge in battery_state of {robot}')
        if charge is not None:
            known = charge
            self._events.put_report(
                lambda supervisor, _, arrived: supervisor.battery(robot, known, arrived),
                f'/{robot}/battery_state')

    def _on_answer(self, message: PlanAnswer) -> None:
        def answered(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            if supervisor is None or not self._topics.is_answered(message):
                return ()
            if message.result != PlanAnswer.PLANNED:
                return supervisor.plan_failed(message.plan_id, message.reason.rstrip('.'), now)
            try:
                outcome = outcome_of(message, self._rate)
            except WrongAnswer as wrong:
                return supervisor.plan_failed(message.plan_id, str(wrong), now)
            return supervisor.plan_made(message.plan_id, outcome, now)
        self._events.put(answered)


def _step_report(subject: str, message: StepStates) -> Optional[StepReport]:
    """Returns the report in a message; None if it cannot be used: then the log says why."""
    try:
        return step_report_of(message)
    except WrongStepMessage as wrong:
        rospy.logwarn_throttle(10.0, f'A report of the steps of {subject} is ignored: {wrong}.')
        return None


def _note_stop_address() -> None:
    """Stores the address of the stop service. `fleet stop` on this computer then needs no ROS
    master.
    """
    try:
        stop_address.note(rosgraph.get_master_uri(),
                          get_service_manager().get_service('/stop_fleet').uri)
    except OSError as error:
        rospy.logwarn('While there is no ROS master, `fleet stop` will not work: the address of '
                      'the stop service cannot be written to the disk (%s).', error)


def main() -> None:
    """Runs the node."""
    run('path_supervisor', PathSupervisor)
