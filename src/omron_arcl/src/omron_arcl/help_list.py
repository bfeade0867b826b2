"""The list of commands that the robot sends at the login."""
from __future__ import annotations

import re
from typing import Mapping, Optional, Tuple

_SHORTCUT = re.compile(r'\[(\w+)\]\s*$')
# Names begin with a letter; a name that is too long for its column touches its description.
_ENTRY = re.compile(r'\s*([A-Za-z]\w*)(?:\s+(\S.*))?$')


class HelpList:
    """The robot's own help list; names are compared without case.

    The list is only information and forbids nothing: a robot may accept commands that it does not
    list, and some lines of the list may be unreadable. `complete`: whether its end was received.
    """

    def __init__(self, descriptions: Mapping[str, str], complete: bool = True) -> None:
        self.descriptions = dict(descriptions)
        self.complete = complete
        self._names = {name.lower(): name for name in descriptions}
        for name, description in descriptions.items():
            shortcut = _SHORTCUT.search(description)
            if shortcut:
                self._names.setdefault(shortcut.group(1).lower(), name)

    def full_name(self, name: str) -> Optional[str]:
        """Returns the full name of the command with the name or shortcut `name`.

        None: the list has no such command.
        """
        return self._names.get(name.lower())

    def __len__(self) -> int:
        return len(self.descriptions)


def read_entry(text: str) -> Optional[Tuple[str, str]]:
    """Returns the name and description from a line of the list, in any layout. None: the line is no
    entry.

    The known robots write a name right-aligned in 15 columns, 10 blanks, and the description.
    """
    match = _ENTRY.match(text)
    return (match.group(1), match.group(2) or '') if match else None
