"""The robot does not take a command."""
from __future__ import annotations

from dataclasses import dataclass

from omron_arcl.replies.reply import Reply


@dataclass(frozen=True)
class CommandError(Reply):
    """The robot refused a command line; `CommandErrorDescription` follows, perhaps not at once."""

    command: str


@dataclass(frozen=True)
class CommandErrorDescription(Reply):
    """Why the command named by the last `CommandError` was refused."""

    text: str


@dataclass(frozen=True)
class UnknownCommand(Reply):
    """The robot has no such command; `name` may be cut short."""

    name: str


@dataclass(frozen=True)
class SetUpError(Reply):
    """A command came in the wrong order, or what it needs is not set up or not there."""

    text: str


@dataclass(frozen=True)
class Usage(Reply):
    """A command lacked arguments; `syntax` is the robot's, the command's name first."""

    syntax: str
