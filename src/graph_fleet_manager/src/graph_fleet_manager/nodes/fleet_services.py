"""The services of the fleet: stop all, resume, and one robot out of service and back."""
from __future__ import annotations

import queue
from typing import Callable, Iterable, List, Optional, Sequence, Tuple

import rospy
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from graph_fleet_manager.nodes.event_loop import Event
from graph_fleet_manager.supervision.actions import Action
from graph_fleet_manager.supervision.supervisor import Supervisor

PATIENCE = 5.0  # s that a call waits for its turn

Act = Callable[[Supervisor, float], Tuple[str, Sequence[Action]]]
"""What a service does: why it is not done (empty: it is), and what is to be done."""


def serve(robots: Iterable[str], put: Callable[[Event], None]) -> List[rospy.Service]:
    """Offers the services; each leaves an event to `put`, and answers with what became of it."""
    def offer(name: str, act: Act, done: str) -> rospy.Service:
        def answer(_: TriggerRequest) -> TriggerResponse:
            return _answer(act, done, put)
        return rospy.Service(name, Trigger, answer)

    def out(robot: str) -> Act:
        return lambda supervisor, now: ('', supervisor.take_out(robot, now))

    def back(robot: str) -> Act:
        return lambda supervisor, now: supervisor.bring_in(robot, now)

    services = [
        offer('/stop_fleet', lambda supervisor, now: ('', supervisor.stop_fleet(now)),
              'Every robot was told to stop.'),
        offer('/resume_fleet', _resume, 'The fleet goes on.')]
    for robot in robots:
        services += [offer(f'/{robot}/leave_fleet', out(robot),
                           f'{robot} was told to stop and is out of service.'),
                     offer(f'/{robot}/join_fleet', back(robot), f'{robot} is in service.')]
    return services


def _resume(supervisor: Supervisor, now: float) -> Tuple[str, Sequence[Action]]:
    problems, actions = supervisor.resume_fleet(now)
    return '; '.join(problems), actions


def _answer(act: Act, done: str, put: Callable[[Event], None]) -> TriggerResponse:
    answer: queue.Queue[TriggerResponse] = queue.Queue(1)

    def event(supervisor: Optional[Supervisor], now: float) -> Sequence[Action]:
        if supervisor is None:
            answer.put(TriggerResponse(False, 'the fleet manager has no graph yet'))
            return ()
        problem, actions = act(supervisor, now)
        answer.put(TriggerResponse(not problem, problem or done))
        return actions
    put(event)
    try:
        return answer.get(timeout=PATIENCE)
    except queue.Empty:
        return TriggerResponse(False, f'not done within {PATIENCE:.0f} s')
