"""Replies by which the robot refuses a command."""
from __future__ import annotations

from dataclasses import dataclass

from omron_arcl.replies.reply import Reply


@dataclass(frozen=True)
class CommandError(Reply):
    """The robot refused a command line; `CommandErrorDescription` follows, possibly later."""

    command: str


@dataclass(frozen=True)
class CommandErrorDescription(Reply):
    """Why the command named by the last `CommandError` was refused."""

    text: str


@dataclass(frozen=True)
class UnknownCommand(Reply):
    """The robot has no such command; `name` may be shortened."""

    name: str


@dataclass(frozen=True)
class SetUpError(Reply):
    """A command came in the wrong order, or something that it needs is missing or not set up."""

    text: str


@dataclass(frozen=True)
class Usage(Reply):
    """A command lacked arguments; `syntax` is the robot's syntax, with the command's name first."""

    syntax: str
