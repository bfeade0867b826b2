"""Predicates on replies, for the table of commands: is this line what the command awaits?"""
from __future__ import annotations

import re
from typing import List

from omron_arcl.commands import Command, Predicate
from omron_arcl.replies import driving, equipment, general, tasks
from omron_arcl.replies.reply import Reply, coordinates


def never(command: Command, reply: Reply) -> bool:
    """No line: what goes on until it is stopped."""
    return False


def is_one_of(*kinds: type) -> Predicate:
    """A reply of one of these kinds, with any content."""
    return lambda command, reply: isinstance(reply, kinds)


def names(kind: type, field: str = 'goal') -> Predicate:
    """A reply of this kind about the command's own goal, route, ... which it has in `field`."""
    return lambda command, reply: (isinstance(reply, kind)
                                   and command.is_for(getattr(reply, field)))


def docking_is(*states: driving.DockingState) -> Predicate:
    """The docking state has come to be one of these."""
    return lambda command, reply: (isinstance(reply, driving.DockingStatus)
                                   and reply.docking in states)


def is_scan(cumulative: bool) -> Predicate:
    """A reading of a range device: what it sees now, or what it has gathered."""
    return lambda command, reply: (isinstance(reply, equipment.RangeReading)
                                   and reply.cumulative is cumulative)


def says(phrase: str) -> Predicate:
    """A confirmation that begins with this phrase."""
    return lambda command, reply: (isinstance(reply, general.Done)
                                   and reply.text.startswith(phrase))


def end_of(what: str) -> Predicate:
    """The end of this list; of the robot's own list, by the names of a fleet manager, too."""
    ends = (what.lower(), f'{what.lower()}local')
    return lambda command, reply: isinstance(reply, general.EndOf) and reply.what in ends


def items(*prefixes: str) -> Predicate:
    """An item of a list, by its prefix."""
    return lambda command, reply: isinstance(reply, general.Item) and reply.prefix in prefixes


def notices(kind: str) -> Predicate:
    """News of this kind."""
    return lambda command, reply: isinstance(reply, general.Notice) and reply.kind == kind


def any_of(*predicates: Predicate) -> Predicate:
    """What fits one of these."""
    return lambda command, reply: any(fits(command, reply) for fits in predicates)


def at_the_point(kind: type) -> Predicate:
    """A reply of this kind about the command's own point.

    Some robots name it by its coordinates, as if it were a goal (ARCL manual I617-E-02 p. 243).
    """
    def fits(command: Command, reply: Reply) -> bool:
        if not isinstance(reply, kind) or not isinstance(reply, _NAMING_A_GOAL):
            return False
        said = coordinates(reply.goal)
        own = coordinates(' '.join(command.arguments[:len(said)]))
        return bool(said) and said == own
    return fits


def same_task(*kinds: type) -> Predicate:
    """The robot repeats a task and its arguments, as typed or as it understood them."""
    def fits(command: Command, reply: Reply) -> bool:
        return (isinstance(reply, kinds) and isinstance(reply, _NAMING_A_TASK)
                and _same_task(_words(reply.task), _words(command.rest)))
    return fits


_NAMING_A_GOAL = (driving.GoingTo, driving.ArrivedAt)
_NAMING_A_TASK = (tasks.WillDoTask, tasks.DoingTask, tasks.CompletedTask)


def _words(task: str) -> List[str]:
    return task.replace('"', ' ').casefold().split()


def _same_task(said: List[str], given: List[str]) -> bool:
    """Equal, but for numbers written otherwise and for variables, which the robot fills in."""
    return (said == given or any('$' in word for word in given) and said[:1] == given[:1]
            or len(said) == len(given) and all(map(_same_word, said, given)))


def _same_word(one: str, other: str) -> bool:
    if one == other:
        return True
    number = re.compile(r'[-+]?\d+(\.\d*)?')
    return bool(number.fullmatch(one) and number.fullmatch(other)) and float(one) == float(other)
