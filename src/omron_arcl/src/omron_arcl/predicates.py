"""Predicates for the table of commands: each says whether a command awaits a reply."""
from __future__ import annotations

import re
from typing import List

from omron_arcl import replies
from omron_arcl.commands import Command, Predicate
from omron_arcl.replies import Reply, coordinates


def never(command: Command, reply: Reply) -> bool:
    """Matches no line. This is for commands that go on until they are stopped."""
    return False


def is_one_of(*kinds: type) -> Predicate:
    """Matches a reply of one of these kinds, with any content."""
    return lambda command, reply: isinstance(reply, kinds)


def names(kind: type, field: str = 'goal') -> Predicate:
    """Matches a reply of this kind whose `field` names the command's own goal, route, ..."""
    return lambda command, reply: (isinstance(reply, kind)
                                   and command.is_for(getattr(reply, field)))


def docking_is(*states: replies.DockingState) -> Predicate:
    """Matches a docking status with one of these states."""
    return lambda command, reply: (isinstance(reply, replies.DockingStatus)
                                   and reply.docking in states)


def is_scan(cumulative: bool) -> Predicate:
    """Matches a reading of a range device: the current one, or the cumulative one."""
    return lambda command, reply: (isinstance(reply, replies.RangeReading)
                                   and reply.cumulative is cumulative)


def says(phrase: str) -> Predicate:
    """Matches a confirmation that begins with this phrase."""
    return lambda command, reply: (isinstance(reply, replies.Done)
                                   and reply.text.startswith(phrase))


def end_of(what: str) -> Predicate:
    """Matches the end of this list, with or without the suffix `local` of a fleet manager."""
    ends = (what.lower(), f'{what.lower()}local')
    return lambda command, reply: isinstance(reply, replies.EndOf) and reply.what in ends


def items(*prefixes: str) -> Predicate:
    """Matches an item of a list by its prefix."""
    return lambda command, reply: isinstance(reply, replies.Item) and reply.prefix in prefixes


def notices(kind: str) -> Predicate:
    """Matches a notice of this kind."""
    return lambda command, reply: isinstance(reply, replies.Notice) and reply.kind == kind


def any_of(*predicates: Predicate) -> Predicate:
    """Matches a line that one of these predicates matches."""
    return lambda command, reply: any(fits(command, reply) for fits in predicates)


def at_the_point(kind: type) -> Predicate:
    """Matches a reply of this kind about the command's own point.

    Some robots write the coordinates as the name of a goal (ARCL manual I617-E-02 p. 243).
    """
    def fits(command: Command, reply: Reply) -> bool:
        if not isinstance(reply, kind) or not isinstance(reply, _NAMING_A_GOAL):
            return False
        said = coordinates(reply.goal)
        own = coordinates(' '.join(command.arguments[:len(said)]))
        return bool(said) and said == own
    return fits


def same_task(*kinds: type) -> Predicate:
    """Matches a reply that repeats the command's task and arguments, in any notation."""
    def fits(command: Command, reply: Reply) -> bool:
        return (isinstance(reply, kinds) and isinstance(reply, _NAMING_A_TASK)
                and _same_task(_words(reply.task), _words(command.rest)))
    return fits


_NAMING_A_GOAL = (replies.GoingTo, replies.ArrivedAt)
_NAMING_A_TASK = (replies.WillDoTask, replies.DoingTask, replies.CompletedTask)


def _words(task: str) -> List[str]:
    return task.replace('"', ' ').casefold().split()


def _same_task(said: List[str], given: List[str]) -> bool:
    """Returns whether both texts mean the same task.

    Numbers may have different notations. If `given` has variables (`$`), only the first words must
    be equal, because the robot replaces variables.
    """
    return (said == given or any('$' in word for word in given) and said[:1] == given[:1]
            or len(said) == len(given) and all(map(_same_word, said, given)))


def _same_word(one: str, other: str) -> bool:
    if one == other:
        return True
    number = re.compile(r'[-+]?\d+(\.\d*)?')
    return bool(number.fullmatch(one) and number.fullmatch(other)) and float(one) == float(other)
