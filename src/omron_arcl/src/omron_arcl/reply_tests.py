"""Ways to tell that a line of the robot is what a command awaits, for the table of commands."""
from __future__ import annotations

from omron_arcl.commands import Command, Test
from omron_arcl.replies import driving, equipment, general
from omron_arcl.replies.reply import Reply


def is_one_of(*kinds: type) -> Test:
    """A reply of one of these kinds, whatever it says."""
    return lambda command, reply: isinstance(reply, kinds)


def names(kind: type, field: str = 'goal') -> Test:
    """A reply of this kind about the command's own goal, route, ... which it has in `field`."""
    return lambda command, reply: (isinstance(reply, kind)
                                   and command.is_for(getattr(reply, field)))


def docking_is(*states: driving.DockingState) -> Test:
    """The docking state has come to be one of these."""
    return lambda command, reply: (isinstance(reply, driving.DockingStatus)
                                   and reply.docking in states)


def is_scan(cumulative: bool) -> Test:
    """A reading of a range device: what it sees now, or what it has gathered."""
    return lambda command, reply: (isinstance(reply, equipment.RangeReading)
                                   and reply.cumulative is cumulative)


def says(phrase: str) -> Test:
    """A confirmation that begins with this phrase."""
    return lambda command, reply: isinstance(reply, general.Done) and reply.text.startswith(phrase)


def end_of(what: str) -> Test:
    """The end of this list."""
    return lambda command, reply: isinstance(reply, general.EndOf) and reply.what == what.lower()


def items(*prefixes: str) -> Test:
    """An item of a list, by its prefix."""
    return lambda command, reply: isinstance(reply, general.Item) and reply.prefix in prefixes


def any_of(*tests: Test) -> Test:
    """What passes one of these tests."""
    return lambda command, reply: any(test(command, reply) for test in tests)


def at_the_point(kind: type) -> Test:
    """A reply of this kind about the command's own point.

    Some robots name it by its coordinates, as if it were a goal (ARCL manual I617-E-02 p. 243).
    """
    return lambda command, reply: (
        isinstance(reply, kind)
        and tuple(reply.goal.split()) in (command.arguments[:2], command.arguments[:3]))


def same_task(*kinds: type) -> Test:
    """The robot repeats a task's arguments as they were typed."""
    def test(command: Command, reply: Reply) -> bool:
        return isinstance(reply, kinds) and _plain(reply.task) == _plain(command.rest)
    return test


def _plain(text: str) -> str:
    return ' '.join(text.replace('"', ' ').split()).casefold()
