"""A command and the specification of its kind: syntax, category, and how its answer ends.

ARCL has no request ids. Only the text of a line connects the line with a command. A specification
therefore contains predicates on replies: which reply acknowledges the command, which replies are
related to it, and which reply completes it. Failures and refusals are the same for all commands;
`attribution` handles them. `judgements` judges drives by the robot's status.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Callable, Optional, Tuple

from omron_arcl.replies import Reply, same_name

ACKNOWLEDGE_TIMEOUT = 60.0  # s within which the robot acknowledges a drive; it may undock first


class Category(Enum):
    """The effect of a command on the robot; the controller allows or refuses by category."""

    QUERY = 'query'  # asks, changes nothing
    MOTION = 'motion'  # drives, stops, docks, localises, or enables driving
    DEVICE = 'device'  # speaks, plays, switches outputs, raises faults
    CONFIGURATION = 'configuration'  # changes the robot's settings or its map
    DANGEROUS = 'dangerous'  # powers off, restarts, frees the wheels, or cuts the link
    UNKNOWN = 'unknown'  # not in the table of commands


class DriveCourse(Enum):
    """The kind of a driving command; it decides which activities contradict the command."""

    TO_A_PLACE = 'to a place'
    INTO_THE_DOCK = 'into the dock'
    OUT_OF_THE_DOCK = 'out of the dock'
    OF_TASKS = 'of tasks'  # a task, macro, list or route: several drives and waits


# Commands of the category MOTION that prepare a drive, or hold the robot back.
_NEVER_MOVE = ('listStart', 'listAdd', 'queueCancelLocal', 'queueModifyLocal', 'stay',
               'applicationBlockDrivingSet')

Predicate = Callable[['Command', Reply], bool]  # whether the command awaits this reply


@dataclass(frozen=True)
class CommandSpec:
    """A row of the table of commands.

    completed_by -- the reply that ends the command with success; None: the answer is not
        documented, and ends when the robot has been quiet for some time
    acknowledged_by -- the reply that shows that the robot obeys; None: no such reply is documented
    related -- further lines that belong to the command
    aborted_by -- the reply that shows that an acknowledged command was broken off
    timeout -- the command times out after so many s without a line or status about it; before it is
        acknowledged, after at most `ACKNOWLEDGE_TIMEOUT`
    course -- set for commands that drive the robot, and so replace the drive before them
    goal_at -- index of the argument that is the name of a goal, route or macro
    shortcut -- a shorter name that the robot also accepts
    needs_standing -- the command is not sent while the robot drives
    adds_job -- each time the command is given, the robot gets one more job

    Its attributes are the columns of the table.
    """

    syntax: str
    category: Category
    completed_by: Optional[Predicate]
    acknowledged_by: Optional[Predicate] = None
    related: Optional[Predicate] = None
    aborted_by: Optional[Predicate] = None
    timeout: float = 5.0
    course: Optional[DriveCourse] = None
    goal_at: Optional[int] = None
    shortcut: str = ''
    needs_standing: bool = False
    adds_job: bool = False

    @property
    def name(self) -> str:
        """The command's name as the manual spells it."""
        return self.syntax.split(' ', 1)[0]

    @property
    def drives(self) -> bool:
        """Whether the command drives the robot, and so replaces the drive before it."""
        return self.course is not None

    @property
    def moves(self) -> bool:
        """Whether the command moves the robot, or lets it move; such a command needs an epoch."""
        return self.drives or (self.category is Category.MOTION and not self.stops
                               and self.name not in _NEVER_MOVE)

    @property
    def may_repeat(self) -> bool:
        """Whether nothing changes if the command is given again while the robot obeys it."""
        return (self.course in (DriveCourse.TO_A_PLACE, DriveCourse.INTO_THE_DOCK)
                and not self.adds_job)

    @property
    def stops(self) -> bool:
        """Whether the command is `stop`, which overtakes all other commands."""
        return self.name == 'stop'

    @property
    def required(self) -> int:
        """The number of arguments that the command needs."""
        return self.syntax.count('<')


@dataclass(frozen=True)
class Command:
    """One line for the robot, as `parse_command` reads it.

    `text` is the line as people read it, `line` has the bytes to send, and `spec` is the row of the
    table of commands.
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
        """The possible names of the command's goal, route or macro; empty if it names none.

        There may be several: the robot also accepts names that contain blanks but have no quotes,
        and `goto` accepts a heading after the goal.
        """
        if self.spec.goal_at is None:
            return ()
        words = self.arguments[self.spec.goal_at:]
        readings = [words[0], ' '.join(words), ' '.join(words[:-1])]
        return tuple(dict.fromkeys(name for name in readings if name))

    def is_for(self, name: str) -> bool:
        """Returns whether `name` may be the name of the command's goal, route or macro."""
        return any(same_name(name, goal) for goal in self.goals)
