"""A command, and what there is to know of its kind: syntax, category, how its answer ends.

ARCL has no request ids, so the only link between a command and the robot's lines is what the lines
say. A specification therefore holds predicates on replies: which one acknowledges the command,
which are related to it, which one completes it. What ends a command badly is the same for all and
is in `endings`; what the robot's status tells of a drive is in `drive_watch`.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Callable, Optional, Tuple

from omron_arcl.replies.reply import Reply, same_name

ACKNOWLEDGE_TIMEOUT = 60.0  # s until a drive must have been acknowledged: it may leave the dock


class Category(Enum):
    """What a command does to the robot; the controller allows or refuses by it."""

    QUERY = 'query'  # asks, changes nothing
    MOTION = 'motion'  # drives, stops, docks, localises, or enables driving
    DEVICE = 'device'  # speaks, plays, switches outputs, raises faults
    CONFIGURATION = 'configuration'  # changes the robot's settings or its map
    DANGEROUS = 'dangerous'  # powers off, restarts, frees the wheels, or cuts the link
    UNKNOWN = 'unknown'  # not in the table of commands


class Course(Enum):
    """What a driving command does with the wheels, and so what contradicts it."""

    TO_A_PLACE = 'to a place'
    INTO_THE_DOCK = 'into the dock'
    OUT_OF_THE_DOCK = 'out of the dock'
    OF_TASKS = 'of tasks'  # a task, macro, list or route: several drives and waits


Predicate = Callable[['Command', Reply], bool]  # is this line what the command awaits?


@dataclass(frozen=True)
class CommandSpec:
    """A row of the table of commands.

    `completed_by`: the reply that ends it well; None: its answer is not documented, and ends when
    the robot has been quiet. `acknowledged_by`: the reply that shows that the robot obeys, None
    where none is promised. `related`: further lines that belong to it. `aborted_by`: once
    acknowledged, the reply that shows that it was broken off. `timeout`: seconds without a line
    or status about it until it has timed out; before it is acknowledged `ACKNOWLEDGE_TIMEOUT` at
    most. `course`: set for commands that take the wheels over, and so replace the one before.
    `goal_at`: which argument is the name of a goal, route or macro. `shortcut`: a shorter name
    that the robot takes, too.
    """

    syntax: str
    category: Category
    completed_by: Optional[Predicate]
    acknowledged_by: Optional[Predicate] = None
    related: Optional[Predicate] = None
    aborted_by: Optional[Predicate] = None
    timeout: float = 5.0
    course: Optional[Course] = None
    goal_at: Optional[int] = None
    shortcut: str = ''

    @property
    def name(self) -> str:
        """The command's name as the manual spells it."""
        return self.syntax.split(' ', 1)[0]

    @property
    def drives(self) -> bool:
        """Whether it takes the wheels over."""
        return self.course is not None

    @property
    def stops(self) -> bool:
        """Whether it is `stop`, which goes before everything else."""
        return self.name == 'stop'

    @property
    def required(self) -> int:
        """How many arguments it needs."""
        return self.syntax.count('<')


@dataclass(frozen=True)
class Command:
    """One line for the robot, as `parse_command` reads it.

    `text` is the line as people read it, `line` the bytes to send; `spec` is the table's row.
    """

    text: str
    line: bytes
    name: str
    arguments: Tuple[str, ...]
    spec: CommandSpec

    @property
    def rest(self) -> str:
        """Everything after the name."""
        return self.text.partition(' ')[2].strip()

    @property
    def goals(self) -> Tuple[str, ...]:
        """The readings of the goal's, route's or macro's name; empty where there is none.

        More than one, because the robot takes names with blanks unquoted too, and `goto` takes a
        heading after the goal.
        """
        if self.spec.goal_at is None:
            return ()
        words = self.arguments[self.spec.goal_at:]
        readings = [words[0], ' '.join(words), ' '.join(words[:-1])]
        return tuple(dict.fromkeys(name for name in readings if name))

    def is_for(self, name: str) -> bool:
        """Whether a reply that names a goal, route or macro means this command's."""
        return any(same_name(name, goal) for goal in self.goals)
