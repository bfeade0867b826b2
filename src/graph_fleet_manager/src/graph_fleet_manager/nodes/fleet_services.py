"""The services of the fleet: stop all, resume, and one robot out of service and back."""
from __future__ import annotations

import queue
import time
from typing import Callable, Iterable, List, Optional, Sequence, Tuple

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from graph_fleet_manager.nodes.event_loop import Event
from graph_fleet_manager.supervision.actions import Action
from graph_fleet_manager.supervision.supervisor import Supervisor

PATIENCE = 5.0       # s that a call waits for its turn
STOP_PATIENCE = 1.0  # s that a stop does, before it goes past a supervisor that hangs

Act = Callable[[Supervisor, float], Tuple[str, Sequence[Action]]]
"""What a service does: why it is not done (empty: it is), and what is to be done."""


class FleetServices:
    """Offers the services; each leaves an event to `put`, and answers with what became of it.

    stop_early -- stops all robots where there is no supervisor to do it, with what is to be said
    past       -- sends a stop past a supervisor that hangs, from any thread
    """

    def __init__(self, robots: Iterable[str], put: Callable[[Event], None],
                 stop_early: Callable[[float], Tuple[str, Sequence[Action]]],
                 past: Callable[[float], None]) -> None:
        self._put, self._stop_early, self._past = put, stop_early, past
        self._services: List[rospy.Service] = [
            rospy.Service('/stop_fleet', Trigger, self.stop),
            self._offer('/resume_fleet', _resume, 'The fleet goes on.')]
        for robot in robots:
            self._services += [
                self._offer(f'/{robot}/leave_fleet', _out(robot),
                            f'{robot} was told to stop and is out of service.'),
                self._offer(f'/{robot}/join_fleet', _back(robot), f'{robot} is in service.')]

    def _offer(self, name: str, act: Act, done: str) -> rospy.Service:
        def answer(_: TriggerRequest) -> TriggerResponse:
            return self._answer(act, done) or TriggerResponse(
                False, f'not done within {PATIENCE:.0f} s')
        return rospy.Service(name, Trigger, answer)

    def stop(self, _: TriggerRequest) -> TriggerResponse:
        """Stops all robots, whatever the supervisor is about."""
        def early(now: float) -> Tuple[TriggerResponse, Sequence[Action]]:
            warning, actions = self._stop_early(now)
            return TriggerResponse(True, f'Every robot was told to stop.{warning}'), actions

        done = self._answer(lambda supervisor, now: ('', supervisor.stop_fleet(now)),
                            'Every robot was told to stop.', STOP_PATIENCE, early)
        if done is not None:
            return done
        self._past(time.monotonic())
        return TriggerResponse(True, 'Every robot was told to stop, past the fleet manager, which '
                                     'hangs: look at its disk and its log.')

    def _answer(self, act: Act, done: str, patience: float = PATIENCE,
                early: Optional[Callable[[float], Tuple[TriggerResponse, Sequence[Action]]]] = None
                ) -> Optional[TriggerResponse]:
        """What became of it; None where nothing did within `patience`."""
        answer: queue.Queue[TriggerResponse] = queue.Queue(1)

        def event(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
            if supervisor is None:
                response, actions = early(now) if early is not None else (
                    TriggerResponse(False, 'the fleet manager has no graph yet, or its disk cannot '
                                           'be written: see /diagnostics'), ())
                answer.put(response)
                return actions
            problem, actions = act(supervisor, now)
            answer.put(TriggerResponse(not problem, problem or done + _warning(supervisor)))
            return actions
        self._put(event)
        try:
            return answer.get(timeout=patience)
        except queue.Empty:
            return None


def _warning(supervisor: Supervisor) -> str:
    return f' {not_stored(supervisor.trouble)}' if supervisor.trouble else ''


def not_stored(trouble: str) -> str:
    """What becomes of something that was done, but is on no disk."""
    return ('If the fleet manager ends before that is stored, it is forgotten: '
            f'{trouble}.')


def _resume(supervisor: Supervisor, now: float) -> Tuple[str, Sequence[Action]]:
    problems, actions = supervisor.resume_fleet(now)
    return '; '.join(problems), actions


def _out(robot: str) -> Act:
    return lambda supervisor, now: ('', supervisor.take_out(robot, now))


def _back(robot: str) -> Act:
    return lambda supervisor, now: supervisor.bring_in(robot, now)
