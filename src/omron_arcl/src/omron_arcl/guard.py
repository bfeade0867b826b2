"""Which commands may go to the robot: what is allowed, what it has, and which goals it knows."""
from __future__ import annotations

from typing import FrozenSet, Iterable, Optional

from omron_arcl import (
    COMMANDS,
    Category,
    Command,
    HelpList,
    InvalidCommand,
    parse_command,
    printable,
)

_DRIVES_TO_A_GOAL = ('goto', 'gotoRouteGoal')


class Guard:
    """Checks a command line before it is sent.

    `allowed` holds categories (`motion`, `query`, ...) and names of commands. `goals` are those of
    the robot, None until it has listed them.
    """

    def __init__(self, allowed: Iterable[str]) -> None:
        words = [word.lower() for word in allowed]
        categories = {category.value: category for category in Category}
        self.categories = frozenset(categories[word] for word in words if word in categories)
        self.names = frozenset(word for word in words if word not in categories)
        self.help = HelpList({})
        self.goals: Optional[FrozenSet[str]] = None

    def unknown_words(self) -> FrozenSet[str]:
        """Words of `allowed` that are neither a category nor a command of the table."""
        return frozenset(word for word in self.names if word not in COMMANDS)

    def check(self, text: str) -> Command:
        """The command that `text` is; raises InvalidCommand with a reason for people."""
        command = parse_command(text, self.help.full_name)
        reason = self._not_allowed(command) or self._not_there(command)
        if reason:
            raise InvalidCommand(printable(text), reason)
        return command

    def _not_allowed(self, command: Command) -> str:
        category = command.spec.category
        if category in self.categories or command.name.lower() in self.names:
            return ''
        return (f'{command.name} is a command of the kind "{category.value}", which '
                f'~allowed_commands does not allow: add "{category.value}" or "{command.name}"')

    def _not_there(self, command: Command) -> str:
        if self.help and not self.help.full_name(command.name):
            return f'the robot has no command {command.name}, by its own help list'
        if (command.spec.name in _DRIVES_TO_A_GOAL and self.goals is not None
                and not any(goal.casefold() in self.goals for goal in command.goals)):
            return (f'the robot has no goal "{command.goals[0]}": load a map that has it into '
                    'the robot')
        return ''
