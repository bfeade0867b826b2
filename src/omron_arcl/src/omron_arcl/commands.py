"""A command, and what there is to know of its kind: syntax, category, how its answer ends.

ARCL has no request ids, so the only link between a command and the robot's lines is what the lines
say. A specification therefore holds tests of replies: which one acknowledges the command, which
belong to it, which one ends it well. What ends it badly is the same for all and is in
`attribution`.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Callable, Optional, Tuple

from omron_arcl.replies.reply import Reply, same_name

PATIENCE = 60.0  # s until a driving command must have begun: leaving the dock comes first


class Category(Enum):
    """What a command does to the robot; the controller allows or refuses by it."""

    QUERY = 'query'  # asks, changes nothing
    MOTION = 'motion'  # drives, stops, docks, localises, or enables driving
    DEVICE = 'device'  # speaks, plays, switches outputs, raises faults
    CONFIGURATION = 'configuration'  # changes the robot's settings or its map
    DANGEROUS = 'dangerous'  # powers off, restarts, frees the wheels, or cuts the link
    UNKNOWN = 'unknown'  # not in the table of commands


Test = Callable[['Command', Reply], bool]  # is this line what the command awaits?


@dataclass(frozen=True)
class CommandSpec:
    """A row of the table of commands.

    `begins`: the reply that shows that the robot obeys, None where none is promised. `belongs`: the
    lines that are its own. `ends`: the last of them. `undone`: once begun, the reply that shows
    that it was broken off. `silence`: seconds without a line of its own until it counts as timed
    out, None for ever; before it began it is `PATIENCE` at most. `drives`: it takes over the
    wheels, and so replaces the one before it.
    """

    syntax: str
    category: Category
    ends: Optional[Test]
    begins: Optional[Test] = None
    belongs: Optional[Test] = None
    undone: Optional[Test] = None
    silence: Optional[float] = 5.0
    drives: bool = False
    goal_at: Optional[int] = None

    @property
    def name(self) -> str:
        """The command's name as the manual spells it."""
        return self.syntax.split(' ', 1)[0]

    @property
    def required(self) -> int:
        """How many arguments it needs."""
        return self.syntax.count('<')


@dataclass(frozen=True)
class Command:
    """One line for the robot, as `parse_command` reads it; `spec` is the table's row for it."""

    text: str
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
