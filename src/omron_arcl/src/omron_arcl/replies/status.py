"""The fields of a status, on separate lines or on one line, and the robot's counters."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

from omron_arcl.replies.reply import Reply


@dataclass(frozen=True)
class ExtendedStatus(Reply):
    """`ExtendedStatusForHumans`: segments joined by `|`."""

    text: str


@dataclass(frozen=True)
class StatusText(Reply):
    """The robot's activity, in the form of another line; parse it with `parse_line`."""

    text: str


@dataclass(frozen=True)
class StateOfCharge(Reply):
    """Charge of the battery in percent."""

    percent: float


@dataclass(frozen=True)
class BatteryVoltage(Reply):
    """Voltage of the battery, which older robots send instead of the charge."""

    volts: float


@dataclass(frozen=True)
class Location(Reply):
    """The robot's pose in its map: mm, mm, degrees (-180..180)."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class LocalizationScore(Reply):
    """How well the laser scan fits the map, 0..1."""

    score: float


@dataclass(frozen=True)
class Temperature(Reply):
    """Degrees Celsius; None if the robot has no sensor (it sends -127 or -128)."""

    celsius: Optional[float]


@dataclass(frozen=True)
class OneLineStatus(Reply):
    """`oneLineStatus`: several status fields on one line; None: the field was not sent.

    ignored -- the fields with impossible values, as they were sent; they count as not sent
    """

    status: str
    extended_status: Optional[str] = None
    state_of_charge: Optional[StateOfCharge] = None
    battery_voltage: Optional[BatteryVoltage] = None
    location: Optional[Location] = None
    localization_score: Optional[LocalizationScore] = None
    temperature: Optional[Temperature] = None
    ignored: Tuple[str, ...] = ()


@dataclass(frozen=True)
class Odometer(Reply):
    """Distance (mm), rotation (degrees) and time (s) since the last reset."""

    distance: float
    rotation: float
    seconds: float


@dataclass(frozen=True)
class DateTime(Reply):
    """The robot's clock, in the robot's format (MM/DD/YYYY HH:MM:SS)."""

    text: str


@dataclass(frozen=True)
class DataStoreValue(Reply):
    """A field of the robot's data store (statistics), with its value in the robot's format."""

    field: str
    value: str
