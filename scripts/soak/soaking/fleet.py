"""The fleet's topics and services, used as a user would use them."""
from __future__ import annotations

import copy
import itertools
import threading
import time
from random import Random
from typing import Any, Callable, Dict, List, Optional, Tuple

import rospy
from std_srvs.srv import Trigger

from graph_fleet_manager.messages.planning import outcome_of, write_outcome
from itrci_nav_msgs.msg import (
    EdgeCommand,
    FleetState,
    MissionCommand,
    MissionRequest,
    MissionStatus,
    PlanAnswer,
)
from node_lifecycle.master_watch import watch_master
from soaking.launch import TRUE_ANSWERS
from world.witness import State, Witness
from world.wrong_plans import WRONG

REPEAT = 5.0  # s after which a mission request without a status is repeated, unchanged
SERVICE = 3.0  # s to wait for a service


class Fleet:
    """Sends requests, receives statuses, and reports both to the witness. A lock guards the
    witness.

    share -- share (0..1) of plan answers that are made wrong
    """

    def __init__(self, witness: Witness, lock: threading.RLock, seed: int, share: float) -> None:
        rospy.init_node('soak', disable_signals=True)
        self.state: Optional[FleetState] = None
        self.told_at = 0.0
        self.answers = self.wrong_answers = 0
        self._witness, self._lock = witness, lock
        self._chance, self._share = Random(seed), share
        self._ids = itertools.count(1)
        self._unanswered: Dict[int, Tuple[float, MissionRequest]] = {}
        self.asking: Dict[int, int] = {}
        """For each mission, the key of the step that asks a person. The lock guards it."""
        self._requests = rospy.Publisher('/mission_request', MissionRequest, queue_size=100)
        self._commands = rospy.Publisher('/mission_command', MissionCommand, queue_size=100)
        self._edges = rospy.Publisher('/edge_command', EdgeCommand, queue_size=10)
        self._plans = rospy.Publisher('/plan_answer', PlanAnswer, queue_size=10)
        self._subscribers = [
            rospy.Subscriber('/fleet_state', FleetState, self._on_state, queue_size=5),
            rospy.Subscriber('/mission_status', MissionStatus, self._on_status, queue_size=1000),
            rospy.Subscriber(TRUE_ANSWERS, PlanAnswer, self._on_answer, queue_size=10)]
        watch_master()

    @property
    def is_connected(self) -> bool:
        """Whether the fleet manager has subscribed to all topics that this object publishes."""
        return bool(self._requests.get_num_connections() and self._plans.get_num_connections()
                    and self._commands.get_num_connections() and self._edges.get_num_connections())

    def answer(self, mission: int, key: int, answer: int) -> None:
        """Answers, as a person, a step that waits for an answer."""
        message = MissionCommand(request_id=mission, command=MissionCommand.ANSWER,
                                 answer=answer, step_key=key)
        message.header.stamp = rospy.Time.now()
        self._commands.publish(message)

    def send(self, destinations: List[int], **more: Any) -> int:
        """Requests a mission. Returns its id."""
        if 'stops' not in more:  # stops contain the destinations
            more['destination_vertices_id'] = destinations
        request = MissionRequest(request_id=next(self._ids), **more)
        request.header.stamp = rospy.Time.now()
        with self._lock:
            self._witness.ask(request.request_id, destinations, time.monotonic())
            self._unanswered[request.request_id] = time.monotonic(), request
        self._requests.publish(request)
        return request.request_id

    def repeat_unanswered(self) -> None:
        """Repeats each request without a status: it may be lost if the fleet manager is killed."""
        with self._lock:
            due = [request for since, request in self._unanswered.values()
                   if time.monotonic() > since + REPEAT]
            for request in due:
                self._unanswered[request.request_id] = time.monotonic(), request
        for request in due:
            self._requests.publish(request)

    def command(self, mission: int, command: int) -> None:
        """Sends a mission command, such as cancel, pause or resume."""
        if command == MissionCommand.CANCEL:
            with self._lock:
                self._witness.cancel(mission)
        message = MissionCommand(request_id=mission, command=command)
        message.header.stamp = rospy.Time.now()
        self._commands.publish(message)

    def edges(self, command: int, edges: List[int]) -> None:
        """Opens or closes edges."""
        message = EdgeCommand(command=command, edges=edges)
        message.header.stamp = rospy.Time.now()
        self._edges.publish(message)

    def call(self, service: str) -> bool:
        """Calls a Trigger service. Returns whether the call succeeded."""
        try:
            rospy.wait_for_service(service, SERVICE)
            return bool(rospy.ServiceProxy(service, Trigger)().success)
        except (rospy.ROSException, rospy.ServiceException, OSError):
            return False

    def robots(self) -> Dict[str, Any]:
        """Returns the last published state of each robot, by name."""
        return {} if self.state is None else {robot.name: robot for robot in self.state.robots}

    def wait_for(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Waits at most `timeout` s for a condition. Returns whether it became true."""
        deadline = time.monotonic() + timeout
        while not condition():
            if time.monotonic() > deadline:
                return False
            time.sleep(0.1)
        return True

    def _on_state(self, state: FleetState) -> None:
        self.state, self.told_at = state, time.monotonic()

    def _on_status(self, status: MissionStatus) -> None:
        with self._lock:
            self._unanswered.pop(status.request_id, None)
            if status.state == MissionStatus.NEEDS_PERSON and status.asks:
                self.asking[status.request_id] = status.asks
            else:
                self.asking.pop(status.request_id, None)
            self._witness.hear(status.request_id, State(status.state), status.robot,
                               status.destinations_reached, status.reason)

    def _on_answer(self, answer: PlanAnswer) -> None:
        self.answers += 1
        if self._chance.random() < self._share:
            self.wrong_answers += 1
            answer = spoilt(answer, self._chance)
        self._plans.publish(answer)


def spoilt(answer: PlanAnswer, chance: Random) -> PlanAnswer:
    """Returns the plan answer, made wrong by one of the functions in `WRONG`."""
    wrong = copy.copy(answer)
    released = {plan.robot: plan.released for plan in answer.plans}
    write_outcome(wrong, chance.choice(list(WRONG.values()))(outcome_of(answer), chance), released)
    return wrong
