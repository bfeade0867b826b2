"""The acts that a client may request. Every field is checked, because it comes from the network.
"""
from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum
from typing import Any, Callable, Dict, Mapping, Tuple

from fleet_core.work.rules import StepDecision
from fleet_core.work.stations import Destination
from fleet_page.core.roles import UserRole

MOST_DESTINATIONS = 100
MOST_EDGES = 1000
MOST_ARGUMENTS = 50
LONGEST_STAY = 1e6  # s, the limit of the fleet manager
_LONGEST_NAME = 100
_INT32 = 2 ** 31 - 1
_UINT64 = 2 ** 64 - 1
ANSWERS = {decision.name.lower(): decision for decision in StepDecision if decision}


class ActKind(Enum):
    """The kind of an act; the value is its name in requests, texts and records."""

    STOP = 'stop'
    RESUME = 'resume'
    SEND = 'send'
    RUN = 'run'
    CANCEL = 'cancel'
    PAUSE = 'pause'
    CONTINUE = 'continue'
    RELEASE = 'release'
    MODIFY = 'modify'
    ANSWER = 'answer'
    CLOSE = 'close'
    OPEN = 'open'
    OUT = 'out'
    IN = 'in'
    ABSENT = 'absent'
    ADD_FAVOURITE = 'add_favourite'
    REMOVE_FAVOURITE = 'remove_favourite'
    ADD_AREA = 'add_area'
    REMOVE_AREA = 'remove_area'
    ACKNOWLEDGE = 'acknowledge'
    PAUSE_TIMETABLE = 'pause_timetable'
    RESUME_TIMETABLE = 'resume_timetable'


@dataclass(frozen=True)
class Act:
    """One act. A field that the act does not need is empty.

    mission -- request id
    robot   -- the robot that the act concerns, or that must serve the mission
    destinations -- ids of vertices, and names of stations and groups
    stays   -- s at each destination, negative: until released; empty: no stays
    name    -- name of a favourite, an area, a template or a timetable, or key of an alarm
    arguments -- of the template, each with the name of its parameter
    answer  -- the answer to a step: one of ANSWERS
    step    -- key of the step that is answered; 0: the step that waits for an answer now

    Each attribute is a field of the browser's message.
    """

    kind: ActKind
    mission: int = 0
    robot: str = ''
    robot_type: str = ''
    priority: int = 0
    destinations: Tuple[Destination, ...] = ()
    stays: Tuple[float, ...] = ()
    edges: Tuple[int, ...] = ()
    name: str = ''
    answer: str = ''
    step: int = 0
    arguments: Tuple[Tuple[str, str], ...] = ()


@dataclass(frozen=True)
class ActOutcome:
    """The outcome of an act. `mission`: the request id of a new mission, else 0."""

    ok: bool
    text: str
    mission: int = 0


class WrongAct(Exception):
    """The request is not valid. The text says what is required."""


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not -_INT32 <= value <= _INT32:
        raise WrongAct('must be a whole number')
    return value


def _ids(value: Any, most: int) -> Tuple[int, ...]:
    if not isinstance(value, list) or not 0 < len(value) <= most:
        raise WrongAct(f'must be a list of 1 to {most} ids')
    ids = tuple(_whole(element) for element in value)
    if any(element <= 0 for element in ids):
        raise WrongAct('must be positive ids')
    return ids


def _destinations(value: Any) -> Tuple[Destination, ...]:
    """Returns destinations: ids of vertices, and names of stations and groups."""
    if not isinstance(value, list) or not 0 < len(value) <= MOST_DESTINATIONS:
        raise WrongAct(f'must be a list of 1 to {MOST_DESTINATIONS} ids or names')
    return tuple(_text(one) if isinstance(one, str) else _ids([one], 1)[0] for one in value)


def _changed_destinations(value: Any) -> Tuple[Destination, ...]:
    return () if value == [] else _ids(value, MOST_DESTINATIONS)


def _edges(value: Any) -> Tuple[int, ...]:
    return _ids(value, MOST_EDGES)


def _text(value: Any) -> str:
    if not isinstance(value, str) or len(value) > _LONGEST_NAME or not (
            value.isprintable() and value.strip()):
        raise WrongAct(f'must be a text of 1 to {_LONGEST_NAME} printable characters')
    return value.strip()


def _text_or_empty(value: Any) -> str:
    return '' if value == '' else _text(value)


def _arguments(value: Any) -> Tuple[Tuple[str, str], ...]:
    if not isinstance(value, dict) or len(value) > MOST_ARGUMENTS:
        raise WrongAct(f'must be an object of at most {MOST_ARGUMENTS} texts')
    return tuple((_text(name), _text(argument)) for name, argument in value.items())


def _stays(value: Any) -> Tuple[float, ...]:
    if not isinstance(value, list) or len(value) > MOST_DESTINATIONS:
        raise WrongAct(f'must be a list of at most {MOST_DESTINATIONS} numbers')
    for element in value:
        # Compared before the conversion, because a whole number of 400 digits cannot become a
        # float.
        if isinstance(element, bool) or not isinstance(element, (int, float)) or not (
                -LONGEST_STAY <= element <= LONGEST_STAY):
            raise WrongAct(f'must be numbers of seconds up to {LONGEST_STAY:.0f}, or negative')
    return tuple(float(element) for element in value)


def _answer(value: Any) -> str:
    if not isinstance(value, str) or value not in ANSWERS:
        raise WrongAct(f'must be one of {", ".join(ANSWERS)}')
    return value


def _step(value: Any) -> int:
    """Returns the key of a step. It is a text, because a browser's numbers have only 53 bits."""
    if not isinstance(value, str) or not re.fullmatch('[0-9]{1,20}', value) or (
            int(value) > _UINT64):
        raise WrongAct('must be the key of a step, as text')
    return int(value)


Field = Callable[[Any], Any]
_MISSION: Dict[str, Field] = {'mission': _whole}
_ROBOT: Dict[str, Field] = {'robot': _text}
_EDGES: Dict[str, Field] = {'edges': _edges}
_NAME: Dict[str, Field] = {'name': _text}


@dataclass(frozen=True)
class Rule:
    """The role that an act needs, its required fields, and its optional fields."""

    role: UserRole
    needed: Mapping[str, Field]
    optional: Mapping[str, Field]


def _rule(role: UserRole, needed: Mapping[str, Field], **optional: Field) -> Rule:
    return Rule(role, needed, optional)


RULES: Dict[ActKind, Rule] = {
    ActKind.STOP: _rule(UserRole.OPERATE, {}),
    ActKind.RESUME: _rule(UserRole.OPERATE, {}),
    ActKind.SEND: _rule(UserRole.OPERATE, {'destinations': _destinations}, robot=_text_or_empty,
                        robot_type=_text_or_empty, priority=_whole, stays=_stays),
    ActKind.RUN: _rule(UserRole.OPERATE, {**_NAME, 'arguments': _arguments}, robot=_text_or_empty,
                       robot_type=_text_or_empty, priority=_whole),
    ActKind.CANCEL: _rule(UserRole.OPERATE, _MISSION),
    ActKind.PAUSE: _rule(UserRole.OPERATE, _MISSION),
    ActKind.CONTINUE: _rule(UserRole.OPERATE, _MISSION),
    ActKind.RELEASE: _rule(UserRole.OPERATE, _MISSION),
    ActKind.MODIFY: _rule(UserRole.OPERATE, {**_MISSION, 'priority': _whole},
                          destinations=_changed_destinations),
    ActKind.ANSWER: _rule(UserRole.OPERATE, {**_MISSION, 'answer': _answer, 'step': _step}),
    ActKind.CLOSE: _rule(UserRole.OPERATE, _EDGES),
    ActKind.OPEN: _rule(UserRole.OPERATE, _EDGES),
    ActKind.OUT: _rule(UserRole.OPERATE, _ROBOT),
    ActKind.IN: _rule(UserRole.OPERATE, _ROBOT),
    ActKind.ABSENT: _rule(UserRole.ADMIN, _ROBOT),
    ActKind.ADD_FAVOURITE: _rule(UserRole.OPERATE, {**_NAME, 'destinations': _destinations},
                                 robot=_text_or_empty, robot_type=_text_or_empty,
                                 priority=_whole, stays=_stays),
    ActKind.REMOVE_FAVOURITE: _rule(UserRole.OPERATE, _NAME),
    ActKind.ADD_AREA: _rule(UserRole.OPERATE, {**_NAME, **_EDGES}),
    ActKind.REMOVE_AREA: _rule(UserRole.OPERATE, _NAME),
    ActKind.ACKNOWLEDGE: _rule(UserRole.OPERATE, _NAME),
    ActKind.PAUSE_TIMETABLE: _rule(UserRole.OPERATE, _NAME),
    ActKind.RESUME_TIMETABLE: _rule(UserRole.OPERATE, _NAME),
}


def act_of(request: Any) -> Act:
    """Returns the act that a request describes; raises WrongAct."""
    if not isinstance(request, dict):
        raise WrongAct('The request must be a JSON object.')
    try:
        kind = ActKind(request.get('act'))
    except ValueError:
        raise WrongAct('There is no such act.') from None
    rule = RULES[kind]
    values: Dict[str, Any] = {}
    for name, value in request.items():
        check = rule.needed.get(name) or rule.optional.get(name)
        if name == 'act':
            continue
        if check is None:
            raise WrongAct(f'{kind.value} takes {", ".join((*rule.needed, *rule.optional))} only.'
                           if rule.needed else f'{kind.value} takes nothing.')
        try:
            values[name] = check(value)
        except WrongAct as wrong:
            raise WrongAct(f'{name} {wrong}.') from None
    for name in rule.needed:
        if name not in values:
            raise WrongAct(f'{name} is missing.')
    act = Act(kind, **values)
    if act.stays and len(act.stays) != len(act.destinations):
        raise WrongAct('stays must be as many as destinations, or none.')
    return act
