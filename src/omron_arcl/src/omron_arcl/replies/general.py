"""List items, confirmations and notices that are not parsed further, and the connection itself."""
from __future__ import annotations

from dataclasses import dataclass

from omron_arcl.replies.reply import Reply


@dataclass(frozen=True)
class Item(Reply):
    """An item of a list, not parsed further; `prefix` is the text before the colon."""

    prefix: str
    text: str


@dataclass(frozen=True)
class EndOf(Reply):
    """The end of a list, in lower case: `goals` for `End of goals`, `rangedevicelist`, ..."""

    what: str


@dataclass(frozen=True)
class HelpEntry(Reply):
    """A command of the robot's help list."""

    name: str
    description: str


@dataclass(frozen=True)
class Done(Reply):
    """An immediate command was carried out; `text` is the line, e.g. `Reset odometer`."""

    text: str


@dataclass(frozen=True)
class Notice(Reply):
    """A notice that needs no action by a client: `kind` QueueUpdate, PayloadUpdate, Charge, ..."""

    kind: str
    text: str


@dataclass(frozen=True)
class Echo(Reply):
    """Whether the server echoes the commands that it receives."""

    on: bool


@dataclass(frozen=True)
class ServerClosing(Reply):
    """The server is about to close the connection; `text` has the reason."""

    text: str
