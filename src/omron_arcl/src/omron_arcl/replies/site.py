"""Replies about the map in use, its objects, and the robot's settings."""
from __future__ import annotations

from dataclasses import dataclass

from omron_arcl.replies.reply import Reply


@dataclass(frozen=True)
class Goal(Reply):
    """A goal of the map in use; docks are not listed."""

    name: str


@dataclass(frozen=True)
class Route(Reply):
    """A route of the map in use."""

    name: str


@dataclass(frozen=True)
class Macro(Reply):
    """A macro of the map in use."""

    name: str


@dataclass(frozen=True)
class DistanceBetween(Reply):
    """Length of the path between two goals, mm."""

    distance: float
    origin: str
    destination: str


@dataclass(frozen=True)
class DistanceFromHere(Reply):
    """Length of the path from the robot to a goal, mm."""

    distance: float
    goal: str


@dataclass(frozen=True)
class MapObjectName(Reply):
    """An object of the map, with its type."""

    name: str
    type: str


@dataclass(frozen=True)
class MapObjectCoord(Reply):
    """Pose of an object of the map: mm, mm, degrees."""

    name: str
    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class MapChanged(Reply):
    """Another map is in use: its goals differ, and the robot may not know its position."""


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
