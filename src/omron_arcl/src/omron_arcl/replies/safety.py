"""Replies about the emergency stop, the motors and faults."""
from __future__ import annotations

from dataclasses import dataclass

from omron_arcl.replies.reply import Reply


@dataclass(frozen=True)
class EStop(Reply):
    """The emergency stop; after its release the motors stay off until they are enabled.

    The manual spells it in four ways; `text` is the robot's own wording.
    """

    pressed: bool
    text: str


@dataclass(frozen=True)
class Motors(Reply):
    """Whether the motors are powered."""

    enabled: bool


@dataclass(frozen=True)
class Fault(Reply):
    """A fault was raised (`cleared`: has ended); sent when it happens, or as an item of a list."""

    kind: str
    name: str
    short: str
    long: str
    driving: bool
    critical: bool
    application: bool
    cleared: bool = False
