"""Replies about the beginning and the end of tasks, macros and task lists."""
from __future__ import annotations

from dataclasses import dataclass

from omron_arcl.replies.reply import Reply


@dataclass(frozen=True)
class WillDoTask(Reply):
    """`doTask` was accepted; `task` is its name and arguments."""

    task: str


@dataclass(frozen=True)
class DoingTask(Reply):
    """A task began."""

    task: str


@dataclass(frozen=True)
class CompletedTask(Reply):
    """A task ended successfully."""

    task: str


@dataclass(frozen=True)
class CompletedInstantTask(Reply):
    """A task that does not interrupt driving is done."""

    task: str


@dataclass(frozen=True)
class ExecutingMacro(Reply):
    """A macro began."""

    macro: str


@dataclass(frozen=True)
class CompletedMacro(Reply):
    """A macro ended successfully."""

    macro: str


@dataclass(frozen=True)
class ExecutingList(Reply):
    """The task list began."""


@dataclass(frozen=True)
class FinishedList(Reply):
    """The task list ended successfully."""


@dataclass(frozen=True)
class WaitState(Reply):
    """State of a wait task."""

    text: str


@dataclass(frozen=True)
class PauseState(Reply):
    """State of a pause task."""

    text: str
