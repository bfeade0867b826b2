"""The publishers of the supervisor: routes, statuses, plan requests, and the fleet's state."""
from __future__ import annotations

from typing import Callable, Dict, Iterable, List, Optional, Sequence, Tuple

import rospy

from fleet_core.interlocking.interlocking import InterlockedRobot
from fleet_core.interlocking.stop_gate import StopGate
from fleet_core.planning.plan_requests import PlanRequest, Times
from fleet_core.supervision.actions import (
    Action,
    AskDevice,
    AskPlanner,
    Note,
    PublishStatus,
    SendRoute,
    SendStep,
)
from fleet_core.supervision.fleet_view import FleetView, plan_progress
from fleet_core.supervision.mission_book import MOST_OPEN
from fleet_core.supervision.missions import Status
from fleet_core.supervision.supervisor import Supervisor
from fleet_core.supervision.timetable_runs import TimetableView
from fleet_core.work.site_work import SiteWork
from graph_fleet_manager.messages import missions as messages
from graph_fleet_manager.messages.edge_times import TimesSent
from graph_fleet_manager.messages.planning import allocations_message, request_message
from graph_fleet_manager.nodes.fleet_plan import FleetPlanTopic
from graph_fleet_manager.nodes.sending import Newcomers, send
from itrci_nav_msgs.msg import (
    DeviceRequest,
    FleetAllocations,
    FleetState,
    MissionStatus,
    MissionTemplates,
    PlanAnswer,
    StepCommand,
    StepParameter,
    TargetRoute,
    Timetables,
)
from itrci_nav_msgs.msg import PlanRequest as PlanRequestMessage
from route_protocol.device_messages import fill_device_request
from route_protocol.step_messages import fill_command

PublishStatuses = Callable[[MissionStatus], None]
"""Publishes a status to one subscriber only."""


class FleetTopics:
    """The publishers of path_supervisor.

    There is an attribute for each topic. Other attributes keep the parts that must stay the same if
    a message is repeated.

    rate        -- factor by which simulated robots are faster than the clock
    improvement -- s in which the planner improves a plan
    newcomer    -- is called for each new subscriber of /mission_status
    gate        -- the stop gate, through which each route passes
    """

    def __init__(self, robots: Iterable[str], rate: float, improvement: float,
                 newcomer: Callable[[PublishStatuses], None], gate: StopGate) -> None:
        self._rate, self._gate = rate, gate
        self._improvement = improvement
        self.graph_stamp = rospy.Time(0)
        self.software: Dict[str, str] = {}
        """The software of the robots that report it, by robot."""
        self._asked: Optional[Tuple[PlanRequestMessage, Times]] = None
        self._times = TimesSent()
        self._route_stamps: Dict[str, rospy.Time] = {}
        self._statuses = rospy.Publisher('/mission_status', MissionStatus, queue_size=2 * MOST_OPEN,
                                         subscriber_listener=Newcomers(newcomer))
        self._states = rospy.Publisher('/fleet_state', FleetState, queue_size=1, latch=True)
        self._plans = FleetPlanTopic(rate)
        self._templates = rospy.Publisher('/mission_templates', MissionTemplates, queue_size=1,
                                          latch=True)
        self._allocations = rospy.Publisher('/fleet_allocations', FleetAllocations, queue_size=1)
        self._timetables = rospy.Publisher('/timetables', Timetables, queue_size=1, latch=True)
        self._timetables_told: Optional[List[TimetableView]] = None
        self._requests = rospy.Publisher('/plan_request', PlanRequestMessage, queue_size=10,
                                         subscriber_listener=Newcomers(self._ask_newcomer))
        self._devices = rospy.Publisher('/device_request', DeviceRequest, queue_size=1000,
                                        tcp_nodelay=True)
        names = tuple(robots)
        self._routes = {robot: rospy.Publisher(f'/{robot}/target_route', TargetRoute,
                                               queue_size=10) for robot in names}
        self._steps = {robot: rospy.Publisher(f'/{robot}/step_command', StepCommand,
                                              queue_size=10, tcp_nodelay=True)
                       for robot in names}
        self._device_steps: Dict[str, rospy.Publisher] = {}

    def begin_devices(self, devices: Iterable[str]) -> None:
        """Advertises step commands for these devices only; topics of earlier devices end."""
        before, self._device_steps = self._device_steps, {}
        for name in devices:
            self._device_steps[name] = before.pop(name, None) or rospy.Publisher(
                f'/devices/{name}/step_command', StepCommand, queue_size=10, tcp_nodelay=True)
        for publisher in before.values():
            publisher.unregister()

    def do(self, actions: Sequence[Action]) -> None:
        """Carries out the actions of the supervisor, in the given order."""
        for action in actions:
            if isinstance(action, SendRoute):
                self._send(action)
            elif isinstance(action, SendStep):
                self._send_step(action)
            elif isinstance(action, AskDevice):
                self._ask_device(action)
            elif isinstance(action, PublishStatus):
                send(self._statuses.publish, status_message(action.status))
            elif isinstance(action, AskPlanner):
                self._ask(action)
            elif isinstance(action, Note):
                (rospy.logwarn if action.is_warning else rospy.loginfo)('%s', action.text)

    def _send(self, action: SendRoute) -> None:
        """Sends a route if the stop gate lets it pass. A repeated route keeps its first stamp."""
        if not action.repeated or action.robot not in self._route_stamps:
            self._route_stamps[action.robot] = rospy.Time.now()
        message = messages.route_message(action.order, self._route_stamps[action.robot],
                                         action.speed)
        with self._gate.passage(action.edges) as passes:
            if passes:
                send(self._routes[action.robot].publish, message)

    def _send_step(self, action: SendStep) -> None:
        message = fill_command(StepCommand(), action.command, StepParameter)
        message.header.stamp = rospy.Time.now()
        publisher = self._device_steps.get(action.device) if action.device else (
            self._steps[action.robot])
        if publisher is not None:  # None: the work file does not have this device any more
            send(publisher.publish, message)

    def _ask_device(self, action: AskDevice) -> None:
        message = fill_device_request(DeviceRequest(), action.request)
        message.request_time = rospy.Time.now()
        send(self._devices.publish, message)

    def _ask(self, question: AskPlanner) -> None:
        stamp = rospy.Time.now()
        message = request_message(
            PlanRequest(question.tasks, question.obstacles, question.closed, time_limit=0.0,
                        improvement=self._improvement, alone=question.alone,
                        seed=question.seed, reserved=question.reserved, laden=question.laden),
            question.number, stamp, self.graph_stamp, self._rate)
        self._times.fill(message, question.edge_times, self._rate)
        self._asked = message, question.edge_times
        send(self._requests.publish, message)

    def _ask_newcomer(self, publish: Callable[[PlanRequestMessage], None]) -> None:
        """Sends the open question to a new subscriber, because a new planner does not have it."""
        asked = self._asked  # an answer may come meanwhile
        if asked is not None:
            publish(asked[0])

    def is_answered(self, answer: PlanAnswer) -> bool:
        """Returns whether this message answers the last plan request.

        If the planner lacked learned times, sends the request again.
        """
        if self._asked is None:
            return False
        question, times = self._asked
        if (answer.plan_id, answer.header.stamp) != (question.plan_id, question.header.stamp):
            return False
        if answer.result != PlanAnswer.OTHER_TIMES:
            self._times.answered(answer.plan_id)
            self._asked = None
            return True
        self._times.is_lost()
        self._times.fill(question, times, self._rate)
        send(self._requests.publish, question)
        return False

    def publish_templates(self, work: SiteWork) -> None:
        """Publishes the templates of the work file."""
        send(self._templates.publish, messages.templates_message(work, rospy.Time.now()))

    def publish_views(self, supervisor: Supervisor, view: FleetView, now: float) -> None:
        """Publishes the state, the plan and the allocations of all robots at the monotonic time
        `now` (s), and timetables that have changed.

        view -- the supervisor's view at that time
        """
        stamp = rospy.Time.now()

        def moment(seconds: float) -> rospy.Time:
            return messages.moment_of(seconds - now, stamp)
        send(self._states.publish, messages.state_message(
            view.robots, view.resources, view.machines, view.stop, moment, stamp, self.software,
            self._rate))
        if self._allocations.get_num_connections():
            robots: Dict[str, InterlockedRobot] = {**supervisor.robots, **supervisor.removed}
            send(self._allocations.publish, allocations_message(
                {name: robot.master.allocation for name, robot in robots.items()}, stamp))
        timetables = supervisor.timetables.views
        if timetables != self._timetables_told:
            self._timetables_told = timetables
            send(self._timetables.publish, messages.timetables_message(timetables, stamp))
        self._plans.set_plan(plan_progress(supervisor), now, stamp)


def status_message(status: Status) -> MissionStatus:
    """Returns a status as a message with the present time as its stamp."""
    return messages.status_message(status, rospy.Time.now())
