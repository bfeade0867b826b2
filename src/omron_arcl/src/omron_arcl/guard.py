"""Decides which commands may be sent to the robot, and which of these the robot might not know."""
from __future__ import annotations

from typing import FrozenSet, Iterable, Optional

from omron_arcl.command_line import printable
from omron_arcl.command_table import COMMANDS
from omron_arcl.commands import Category, Command
from omron_arcl.errors import InvalidCommand
from omron_arcl.help_list import HelpList
from omron_arcl.records import DriveMemory, MotionState, RobotMotion

_DRIVES_TO_A_GOAL = ('goto', 'gotoRouteGoal')


class Guard:
    """Checks a command before it is sent. `stop` is always allowed.

    `allowed` contains categories (`motion`, `query`, ...) and names of commands. `goals` are the
    goals that the robot has listed; None while they are unknown. `motion` is the motion according
    to the records of drives.
    """

    def __init__(self, allowed: Iterable[str]) -> None:
        words = [word.lower() for word in allowed]
        categories = {category.value: category for category in Category}
        self.categories = frozenset(categories[word] for word in words if word in categories)
        self.names = frozenset(word for word in words if word not in categories)
        self.goals: Optional[FrozenSet[str]] = None
        self.motion = RobotMotion(DriveMemory(0), MotionState.UNKNOWN, False)

    def list_goals(self, names: Iterable[str]) -> None:
        """Stores the goals that the robot has listed; an empty list forbids nothing."""
        self.goals = frozenset(name.casefold() for name in names) or None

    def unknown_words(self) -> FrozenSet[str]:
        """Returns the words of `allowed` that are neither a category nor a command of the table."""
        return frozenset(word for word in self.names if word not in COMMANDS)

    def check(self, command: Command) -> None:
        """Raises InvalidCommand, with a reason for a person, if a command must not be sent."""
        if command.spec.stops:
            return
        reason = (self._not_allowed(command) or self._no_such_goal(command)
                  or self._while_it_drives(command))
        if reason:
            raise InvalidCommand(printable(command.text), reason)

    def _not_allowed(self, command: Command) -> str:
        category = command.spec.category
        if category in self.categories or command.name.lower() in self.names:
            return ''
        return (f'{command.name} is a command of the kind "{category.value}", which '
                f'~allowed_commands does not allow: add "{category.value}" or "{command.name}"')

    def _no_such_goal(self, command: Command) -> str:
        if (command.spec.name in _DRIVES_TO_A_GOAL and self.goals is not None
                and not any(goal.casefold() in self.goals for goal in command.goals)):
            return (f'the robot has no goal "{printable(command.goals[0])}": load a map with this '
                    'goal into the robot')
        return ''

    def _while_it_drives(self, command: Command) -> str:
        if command.spec.needs_standing and self.motion.is_driving:
            return 'the robot drives: stop it first, and give the command when it stands'
        return ''


def is_unlisted(command: Command, help_list: HelpList) -> bool:
    """Returns whether the robot's own help list lacks a command. The robot may still accept it."""
    return bool(help_list.descriptions) and not (
        help_list.full_name(command.name)
        or help_list.full_name(command.text.split(' ', 1)[0]))
