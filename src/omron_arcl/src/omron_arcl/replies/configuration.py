"""The robot's settings."""
from __future__ import annotations

from dataclasses import dataclass

from omron_arcl.replies.reply import Reply


@dataclass(frozen=True)
class ConfigValue(Reply):
    """A key of a configuration section, with its value."""

    key: str
    value: str


@dataclass(frozen=True)
class ConfigErrors(Reply):
    """The configuration was loaded with errors."""

    text: str


@dataclass(frozen=True)
class ConfigurationChanged(Reply):
    """A configuration was loaded."""
