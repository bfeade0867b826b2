"""Stops and their steps in messages."""
from __future__ import annotations

from typing import Iterable, List, Sequence, Tuple

from fleet_core.supervision.missions import StepAnswer
from fleet_core.work.dependencies import Dependency, Until
from fleet_core.work.rules import StepDecision
from fleet_core.work.stops import (
    Actor,
    Condition,
    LoadEffect,
    Policy,
    StepBlocking,
    StopKind,
    When,
    WorkStep,
    WorkStop,
)
from itrci_nav_msgs import msg


class WrongStopMessage(ValueError):
    """Stops with a number that has no meaning. The text is a clause that names the number."""


def stops_of(messages: Iterable[msg.MissionStop]) -> Tuple[WorkStop, ...]:
    """Returns the stops in messages. Raises WrongStopMessage."""
    try:
        return tuple(WorkStop(one.vertex, StopKind(one.kind), tuple(map(_step_of, one.steps)),
                          Condition(one.condition), _group_of(one)) for one in messages)
    except WrongStopMessage:
        raise
    except ValueError as error:
        raise WrongStopMessage(f'a stop or a step has a constant that does not exist ({error})'
                               ) from None


def _group_of(message: msg.MissionStop) -> str:
    """Returns the group of a stop. Raises WrongStopMessage if the stop also has a vertex."""
    if message.group and message.vertex:
        raise WrongStopMessage(f'a stop has vertex {message.vertex} and also a group: give one of '
                               'them')
    return str(message.group)


def _step_of(message: msg.MissionStep) -> WorkStep:
    return WorkStep(message.type, message.timeout,
                tuple((one.name, one.value) for one in message.parameters), When(message.when),
                Actor(message.actor), StepBlocking(message.blocking), Policy(message.on_failure),
                message.retries, message.harmless, message.breakable, LoadEffect(message.load),
                message.device, message.load_type)


def stop_messages(stops: Sequence[WorkStop]) -> List[msg.MissionStop]:
    """Stops as messages."""
    return [msg.MissionStop(vertex=0 if stop.group else stop.place, group=stop.group,
                            kind=int(stop.kind), condition=int(stop.condition),
                            steps=[_step_message(step) for step in stop.steps])
            for stop in stops]


def _step_message(step: WorkStep) -> msg.MissionStep:
    return msg.MissionStep(
        type=step.type, parameters=[msg.StepParameter(*pair) for pair in step.parameters],
        when=int(step.when), actor=int(step.actor), blocking=int(step.blocking),
        timeout=step.timeout, on_failure=int(step.on_failure), retries=step.retries,
        harmless=step.harmless, breakable=step.breakable, load=int(step.load),
        device=step.device, load_type=step.load_type)


def dependencies_of(messages: Iterable[msg.MissionDependency]) -> Tuple[Dependency, ...]:
    """Returns the missions that must end before this mission begins. Raises WrongStopMessage."""
    try:
        return tuple(Dependency(one.request_id, Until(one.until)) for one in messages)
    except ValueError as error:
        raise WrongStopMessage(f'its `after` has a constant that does not exist ({error})'
                               ) from None


def answer_of(message: msg.MissionCommand) -> StepAnswer:
    """Returns the answer to a step in a command. Raises WrongStopMessage."""
    try:
        answer = StepDecision(message.answer)
    except ValueError:
        answer = StepDecision.NONE
    if answer is StepDecision.NONE:
        raise WrongStopMessage(f'its answer is {message.answer}, which does not exist')
    return StepAnswer(answer, message.step_key)
