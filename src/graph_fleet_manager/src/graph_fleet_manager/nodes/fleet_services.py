"""The services of the fleet.

They stop and resume all robots; take one robot out of service and put it back; declare it absent;
declare what it carries; and pause a timetable. They also return the status of a mission, and what a
mission waits for.
"""
from __future__ import annotations

import queue
import threading
import time
from typing import Callable, Iterable, List, Optional, Sequence, Tuple, TypeVar, Union

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from fleet_core.interlocking.stop_gate import StopGate
from fleet_core.supervision.actions import Action
from fleet_core.supervision.fleet_stop import FleetStop, StopCause
from fleet_core.supervision.journal_database import JournalUnavailable
from fleet_core.supervision.supervisor import Supervisor
from fleet_core.supervision.why import mission_reason
from graph_fleet_manager.messages.missions import (
    caller_of,
    explanation_message,
    person_of,
    status_message,
)
from graph_fleet_manager.nodes.event_loop import SupervisorEvents
from itrci_nav_msgs.srv import (
    ChargeRobot,
    ChargeRobotRequest,
    ChargeRobotResponse,
    DeclareAbsent,
    DeclareAbsentRequest,
    DeclareAbsentResponse,
    ExplainMission,
    ExplainMissionRequest,
    ExplainMissionResponse,
    GetMissionStatus,
    GetMissionStatusRequest,
    GetMissionStatusResponse,
    PauseTimetable,
    PauseTimetableRequest,
    PauseTimetableResponse,
    SetLoad,
    SetLoadRequest,
    SetLoadResponse,
)

PATIENCE = 5.0       # s that a call waits for the supervisor
STOP_PATIENCE = 0.5  # s after which a stop bypasses a supervisor that does not react

Act = Callable[[Supervisor, float], Tuple[str, Sequence[Action]]]
"""The work of a service. Returns the reason why it is not done (empty if done), and actions."""
_Found = TypeVar('_Found')
Done = Union[str, Callable[[Supervisor], str]]
"""The answer to a call that was carried out, or a function that returns this answer."""


class FleetServices:
    """Offers the services. Each call queues an event and answers with its result.

    gate       -- the stop gate, through which each route passes; a stop closes it at once
    stop_early -- stops all robots while there is no supervisor; returns a warning and actions
    past       -- sends a stop from any thread, even if the supervisor hangs
    """

    def __init__(self, robots: Iterable[str], gate: StopGate, events: SupervisorEvents,
                 stop_early: Callable[[float, FleetStop], Tuple[str, Sequence[Action]]],
                 past: Callable[[float, FleetStop], None]) -> None:
        self._gate, self._events, self._stop_early, self._past = gate, events, stop_early, past
        self._robots = frozenset(robots)
        self._services: List[rospy.Service] = [
            rospy.Service('/stop_fleet', Trigger, lambda request: _logged(
                _requested('/stop_fleet', request), self.stop(request))),
            rospy.Service('/resume_fleet', Trigger, self._resume),
            rospy.Service('/pause_timetable', PauseTimetable, self._pause_timetable),
            rospy.Service('/get_mission_status', GetMissionStatus, self._mission_status),
            rospy.Service('/explain_mission', ExplainMission, self._explanation)]
        for robot in robots:
            self._services += [
                self._offer_absence(robot, f'{robot} is absent until it reports again.'),
                self._offer_load(robot),
                self._offer_charging(robot),
                self._offer(f'/{robot}/leave_fleet', _out(robot),
                            f'{robot} was told to stop and is out of service.', lasts=True),
                self._offer(f'/{robot}/join_fleet', _back(robot), f'{robot} is in service.')]

    def _offer(self, name: str, act: Act, done: str, lasts: bool = False) -> rospy.Service:
        return rospy.Service(name, Trigger, lambda _: self._called(name, act, done, lasts))

    def _offer_absence(self, robot: str, done: str) -> rospy.Service:
        name = f'/{robot}/declare_absent'

        def answer(request: DeclareAbsentRequest) -> DeclareAbsentResponse:
            by = person_of(request.requested_by)
            rospy.loginfo('%s is requested%s.', name, f' by {by}' if by else '')
            told = self._called(name, _absent(robot), done)
            return DeclareAbsentResponse(told.success, told.message)
        return rospy.Service(name, DeclareAbsent, answer)

    def _offer_load(self, robot: str) -> rospy.Service:
        name = f'/{robot}/set_load'

        def answer(request: SetLoadRequest) -> SetLoadResponse:
            by = person_of(request.requested_by)
            mission = request.request_id if request.loaded else None
            rospy.loginfo('%s: %s is requested%s.', name,
                          'empty' if mission is None else f'the load of mission {mission}',
                          f' by {by}' if by else '')
            told = self._called(name, _load(robot, mission), f'{robot} carries ' + (
                'nothing.' if mission is None else f'the load of mission {mission}.'))
            return SetLoadResponse(told.success, told.message)
        return rospy.Service(name, SetLoad, answer)

    def _offer_charging(self, robot: str) -> rospy.Service:
        name = f'/{robot}/charge'

        def answer(request: ChargeRobotRequest) -> ChargeRobotResponse:
            by = person_of(request.requested_by)
            until = f'until {100.0 * request.until:.0f} %' if request.until else 'not any more'
            rospy.loginfo('%s: %s is requested%s.', name, until, f' by {by}' if by else '')
            told = self._called(name, _charge(robot, request.until), (
                f'{robot} charges {until} when it has no mission.' if request.until
                else f'{robot} charges only when it must.'))
            return ChargeRobotResponse(told.success, told.message)
        return rospy.Service(name, ChargeRobot, answer)

    def _called(self, name: str, act: Act, done: Done, lasts: bool = False) -> TriggerResponse:
        late = 'but it will be done' if lasts else 'and it will not be done'
        return _logged(name, self._answer(act, done, lasts=lasts) or TriggerResponse(
            False, f'not done within {PATIENCE:.0f} s, {late}: look at the disk of the fleet '
                   'manager, and at its log'))

    def stop(self, request: TriggerRequest) -> TriggerResponse:
        """Stops all robots, even while the supervisor is busy."""
        self._gate.close()
        stop = FleetStop(StopCause.PERSON, caller_of(request), time.time())

        def early(now: float) -> Tuple[TriggerResponse, Sequence[Action]]:
            warning, actions = self._stop_early(now, stop)
            return TriggerResponse(True, f'Every robot was told to stop.{warning}'), actions

        done = self._answer(lambda supervisor, now: ('', supervisor.stop_fleet(now, stop)),
                            'Every robot was told to stop.', STOP_PATIENCE, early, lasts=True)
        if done is not None:
            return done
        self._past(time.monotonic(), stop)
        return TriggerResponse(True, 'Every robot was told to stop directly, because the fleet '
                                     'manager hangs: look at its disk and its log.')

    def _resume(self, request: TriggerRequest) -> TriggerResponse:
        """Ends the fleet stop, unless a further stop of the fleet is requested before that."""
        ticket = self._gate.ticket

        def resume(supervisor: Supervisor, now: float) -> Tuple[str, Sequence[Action]]:
            return supervisor.resume_fleet(now, ticket)
        return self._called(_requested('/resume_fleet', request), resume,
                            lambda supervisor: supervisor.who_goes_on)

    def _pause_timetable(self, request: PauseTimetableRequest) -> PauseTimetableResponse:
        name, by = request.timetable, person_of(request.requested_by)
        what = 'paused' if request.paused else 'continued'
        rospy.loginfo('/pause_timetable: %r is to be %s%s.', name, what,
                      f', requested by {by}' if by else '')
        told = self._called('/pause_timetable', _pause(name, request.paused), (
            f'Timetable {name} is paused.' if request.paused else f'Timetable {name} goes on.'))
        return PauseTimetableResponse(told.success, told.message)

    def _mission_status(self, request: GetMissionStatusRequest) -> GetMissionStatusResponse:
        """Returns the stored status of a mission. Raises ServiceException if it cannot be read."""
        def find(supervisor: Supervisor, _: float) -> GetMissionStatusResponse:
            status = supervisor.stored_status(request.request_id, request.request_stamp.to_sec())
            return GetMissionStatusResponse() if status is None else (
                GetMissionStatusResponse(True, status_message(status, rospy.Time.now())))
        return self._found(find)

    def _explanation(self, request: ExplainMissionRequest) -> ExplainMissionResponse:
        """Returns what an open mission waits for. Raises ServiceException without an answer."""
        def find(supervisor: Supervisor, now: float) -> ExplainMissionResponse:
            mission = supervisor.book.find(request.request_id)
            if mission is None or not mission.state.is_open:
                return ExplainMissionResponse()
            return explanation_message(mission.status, mission_reason(mission, supervisor, now))
        return self._found(find)

    def _found(self, find: Callable[[Supervisor, float], _Found]) -> _Found:
        """Calls `find` in the supervisor's thread, and returns its result.

        Raises ServiceException if the journal cannot be read now, or if there is no answer.
        """
        found: List[_Found] = []

        def read(supervisor: Supervisor, now: float) -> Tuple[str, Sequence[Action]]:
            try:
                found.append(find(supervisor, now))
            except JournalUnavailable as unavailable:
                return unavailable.reason, ()
            return '', ()
        answer = self._answer(read, '')
        if not found:
            raise rospy.ServiceException(
                answer.message if answer else f'no answer within {PATIENCE:.0f} s')
        return found[0]

    def offer_removed(self, robots: Iterable[str]) -> None:
        """Offers to declare each of these robots ABSENT, unless it is in the fleet file."""
        for robot in sorted(set(robots) - self._robots):
            self._robots |= {robot}
            self._services.append(self._offer_absence(robot, f'{robot} is forgotten.'))

    def _answer(self, act: Act, done: Done, patience: Optional[float] = None,
                early: Optional[Callable[[float], Tuple[TriggerResponse, Sequence[Action]]]] = None,
                lasts: bool = False) -> Optional[TriggerResponse]:
        """Returns the answer to a call; None if the call did not begin within `patience` (s).

        Such a call is then given up: after a person was told that robots do not go on, the robots
        must not go on later.

        lasts -- True: the call stops robots; it is urgent, and is carried out even after `patience`
        """
        answer: queue.Queue[TriggerResponse] = queue.Queue(1)
        turn = threading.Lock()  # acquired once: by the call, or to give the call up

        def event(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            if not turn.acquire(blocking=False):
                return ()
            if supervisor is None:
                response, actions = early(now) if early is not None else (
                    TriggerResponse(False, 'the fleet manager has no graph yet, its work file '
                                           'does not fit the graph, or its disk cannot be '
                                           'written: see /diagnostics'), ())
                answer.put(response)
                return actions
            problem, actions = act(supervisor, now)
            told = done if isinstance(done, str) else done(supervisor)
            answer.put(TriggerResponse(not problem, problem or told + _warning(supervisor)))
            return actions
        (self._events.put_urgent if lasts else self._events.put)(event)
        patience = PATIENCE if patience is None else patience
        try:
            return answer.get(timeout=patience)
        except queue.Empty:
            if lasts or turn.acquire(blocking=False):
                return None
        return TriggerResponse(False, f'begun, but not done within {patience:.0f} s: look at its '
                                      'disk and its log')


def _requested(service: str, request: TriggerRequest) -> str:
    """Returns the name of a service and the person or program that calls it, for the log."""
    by = caller_of(request)
    return f'{service}, requested by {by}' if by else service


def _logged(service: str, answer: TriggerResponse) -> TriggerResponse:
    """Logs an answer and returns it. So a call is in the log before its caller gets the answer."""
    rospy.loginfo('%s: %s%s', service, '' if answer.success else 'not done: ', answer.message)
    return answer


def _warning(supervisor: Supervisor) -> str:
    return f' {not_stored(supervisor.trouble)}' if supervisor.trouble else ''


def not_stored(trouble: str) -> str:
    """Returns a warning that a change is not on the disk; `trouble` is a clause that says why."""
    return ('If the fleet manager ends before this is stored, it is forgotten: '
            f'{trouble}.')


def _out(robot: str) -> Act:
    return lambda supervisor, now: ('', supervisor.take_out(robot, now))


def _back(robot: str) -> Act:
    return lambda supervisor, now: supervisor.bring_in(robot, now)


def _absent(robot: str) -> Act:
    return lambda supervisor, now: supervisor.declare_absent(robot, now)


def _pause(timetable: str, paused: bool) -> Act:
    return lambda supervisor, now: supervisor.pause_timetable(timetable, paused, now)


def _charge(robot: str, until: float) -> Act:
    return lambda supervisor, now: supervisor.charge(robot, until, now)


def _load(robot: str, mission: Optional[int]) -> Act:
    return lambda supervisor, now: supervisor.set_load(robot, mission, now)
