"""Stops and their steps, as they are requested for a mission, and the rules for refusing them."""
from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Sequence, Tuple

from route_protocol.steps import HAND_OVER

MOST_STOPS = 1000       # maximum number of stops of a mission, including `on_cancel`
MOST_STEPS = 50         # maximum number of steps of a stop
LONGEST_TIMEOUT = 1e6   # s; a longer timeout is a mistake
MOST_RETRIES = 100
_LONGEST_TEXT = 256     # maximum number of letters of a type or parameter
_MOST_PARAMETERS = 20


class StopKind(IntEnum):
    """What a stop is for, as in itrci_nav_msgs/MissionStop."""

    VISIT = 0
    PICKUP = 1
    DROPOFF = 2
    PARK = 3
    CHARGE = 4


class Condition(IntEnum):
    """When a stop of `on_cancel` is made, as in itrci_nav_msgs/MissionStop."""

    ALWAYS = 0
    LOADED = 1
    EMPTY = 2


class When(IntEnum):
    """When a step is carried out, as in itrci_nav_msgs/MissionStep."""

    AT = 0
    BEFORE_ENTRY = 1
    BEFORE_LEAVING = 2


class Actor(IntEnum):
    """The kind of the actor of a step, as in itrci_nav_msgs/MissionStep."""

    ROBOT = 0
    PERSON = 1
    OUTSIDE = 2   # a program, which answers with a mission command
    DEVICE = 3    # a press or a conveyor; the work file has its address

    @property
    def has_driver(self) -> bool:
        """Whether the actor obeys step commands and reports how a step ends.

        For the other actors, the answer of a person or program says how the step has ended.
        """
        return self in (Actor.ROBOT, Actor.DEVICE)


class StepBlocking(IntEnum):
    """What may happen while a step runs, as in itrci_nav_msgs/MissionStep and in VDA 5050."""

    HARD = 0   # the robot stands, and no other step runs
    SOFT = 1   # the robot stands
    NONE = 2   # the robot may drive


class Policy(IntEnum):
    """What follows a step that has failed, as in itrci_nav_msgs/MissionStep."""

    ASK = 0
    FAIL = 1
    RETRY = 2   # repeat as many times as `retries` says, then ASK
    SKIP = 3


class LoadEffect(IntEnum):
    """What a step that is DONE does to the robot's load, as in itrci_nav_msgs/MissionStep."""

    NONE = 0
    TAKES = 1
    GIVES = 2


@dataclass(frozen=True)
class WorkStep:
    """One step of a stop.

    type       -- name of the kind of work, which the actor knows
    timeout    -- s after which its outcome counts as unknown
    retries    -- for RETRY: how many times it is repeated
    harmless   -- it may be carried out twice, so it may be repeated if its outcome is unknown
    breakable  -- the step is broken off when its mission is cancelled or its time is over
    device     -- for DEVICE: name of the device that carries it out
    load_type  -- the type of load that it takes, as in the work file; empty: it is not known

    Each attribute is a part of the step, as it is stored.
    """

    type: str
    timeout: float
    parameters: Tuple[Tuple[str, str], ...] = ()
    when: When = When.AT
    actor: Actor = Actor.ROBOT
    blocking: StepBlocking = StepBlocking.HARD
    on_failure: Policy = Policy.ASK
    retries: int = 0
    harmless: bool = False
    breakable: bool = False
    load: LoadEffect = LoadEffect.NONE
    device: str = ''
    load_type: str = ''


@dataclass(frozen=True)
class WorkStop:
    """One stop: a vertex, and the steps there.

    place     -- vertex; for a group, the chosen vertex; 0 in a request: none is chosen yet
    condition -- for a stop after a cancellation: the load with which the robot makes it
    group     -- name of a group: the stop may be at any place of the group; empty: only at `place`
    """

    place: int
    kind: StopKind = StopKind.VISIT
    steps: Tuple[WorkStep, ...] = ()
    condition: Condition = Condition.ALWAYS
    group: str = ''


def dwells_of(stops: Sequence[WorkStop]) -> Tuple[float, ...]:
    """Returns the dwells at the destinations: at each one, a robot stays until its work has ended.

    At the last stop it stays until all steps of the mission have ended.
    """
    last = len(stops) - 1
    return tuple(-1.0 if stop.steps or k == last else 0.0 for k, stop in enumerate(stops))


class WrongStops(Exception):
    """Stops that are not accepted. The text is a clause that says why and what to do."""


def check_stops(stops: Sequence[WorkStop], on_cancel: Sequence[WorkStop]) -> None:
    """Raises WrongStops for stops that could not be carried out."""
    if len(stops) + len(on_cancel) > MOST_STOPS:
        raise WrongStops(f'it has more than {MOST_STOPS} stops, those of on_cancel included')
    for number, stop in enumerate(stops, 1):
        if stop.condition is not Condition.ALWAYS:
            raise WrongStops(f'stop {number} has a condition, which only stops of on_cancel have')
    for words, some in (('stop', stops), ('stop of on_cancel', on_cancel)):
        for number, stop in enumerate(some, 1):
            if len(stop.steps) > MOST_STEPS:
                raise WrongStops(f'{words} {number} has more than {MOST_STEPS} steps')
            for k, step in enumerate(stop.steps, 1):
                problem = problem_of(step)
                if problem:
                    name = ''.join(one if one.isprintable() else '?' for one in step.type[:40])
                    raise WrongStops(f'step {k} ({name}) of {words} {number} {problem}')


def problem_of(step: WorkStep) -> str:
    """Returns why a step is refused, such as 'needs a type'; '': it is not refused."""
    texts = (step.type, step.device, step.load_type,
             *(text for pair in step.parameters for text in pair))
    names = [name for name, _ in step.parameters]
    rules = (
        (not step.type, 'needs a type'),
        (any(not text.isprintable() or len(text) > _LONGEST_TEXT for text in texts),
         f'has a text that cannot be printed, or has more than {_LONGEST_TEXT} letters'),
        (len(names) > _MOST_PARAMETERS, f'has more than {_MOST_PARAMETERS} parameters'),
        (len(names) != len(set(names)), 'has two parameters with one name'),
        (not (math.isfinite(step.timeout) and 0.0 < step.timeout <= LONGEST_TIMEOUT),
         f'needs a timeout above 0 and up to {LONGEST_TIMEOUT:.0f} s'),
        ((step.actor is Actor.DEVICE) is not bool(step.device),
         'needs the name of a device if its actor is DEVICE, and none otherwise'),
        (step.actor is Actor.DEVICE and (step.type != HAND_OVER or bool(step.parameters)),
         f'is for a device: its type must be {HAND_OVER}, and it must not have parameters'),
        (not 0 <= step.retries <= MOST_RETRIES or (
            (step.on_failure is Policy.RETRY) is not bool(step.retries)),
         f'needs retries (1 to {MOST_RETRIES}) if on_failure is RETRY, and none otherwise'),
        (bool(step.load_type) and step.load is not LoadEffect.TAKES,
         'has a load_type, but does not take a load'),
        *(_rules_of_load(step) if step.load else ()))
    return next((text for is_wrong, text in rules if is_wrong), '')


def _rules_of_load(step: WorkStep) -> Tuple[Tuple[bool, str], ...]:
    """Returns, for each rule about loads, whether the step breaks the rule, and a text."""
    return (
        (step.blocking is not StepBlocking.HARD, 'changes the load, so its blocking must be HARD'),
        (step.when is not When.AT, 'changes the load, so it must be carried out AT the stop'),
        (step.on_failure is Policy.SKIP,
         'changes the load, so it cannot be skipped without a person: choose ASK'),
        (step.harmless, 'changes the load, so it is not harmless'))
