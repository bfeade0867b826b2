"""Inputs, outputs, payload, application faults and clients' infos of the robot."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, Iterable, Optional, Tuple

from omron_ld90_sim.devices.external_io import IoSet

SLOTS = 4       # payload slots of a robot with the default configuration (I617-E-02 p. 48)


def find_name(names: Iterable[str], wanted: str) -> Optional[str]:
    """Returns the name in `names` that equals `wanted`, ignoring case; None: there is none."""
    return next((name for name in names if name.lower() == wanted.lower()), None)


@dataclass(frozen=True)
class ApplicationFault:
    """A fault raised by an application; `str` returns the fields of its `Fault:` line."""

    name: str
    short: str
    long: str
    driving: bool
    critical: bool

    def __str__(self) -> str:
        kind = ('Fault' + ('_Driving' if self.driving else '')
                + ('_Critical' if self.critical else '') + '_Application')
        flags = ' '.join('true' if flag else 'false'
                         for flag in (self.driving, self.critical, True))
        return f'{kind} {self.name} "{self.short}" "{self.long}" {flags}'


@dataclass
class AnalogInput:
    """An analog input: range in volts, counts at full scale, present voltage."""

    minimum: float = 0.0
    maximum: float = 10.0
    maximum_raw: int = 4095
    voltage: float = 0.0

    @property
    def raw(self) -> int:
        """The voltage in counts."""
        fraction = (self.voltage - self.minimum) / (self.maximum - self.minimum)
        return round(fraction * self.maximum_raw)


@dataclass(frozen=True)
class Load:
    """The content of a payload slot, and the time of loading (`MM/DD/YYYY hh:mm:ss`)."""

    text: str
    since: str


def _switches(name: str) -> Dict[str, bool]:
    return {f'{name}_{n}': False for n in range(1, 5)}


@dataclass
class Equipment:
    """The robot's equipment: four digital inputs, four digital outputs and an analog input.

    Their names are invented, because the names on real robots are not known.
    """

    inputs: Dict[str, bool] = field(default_factory=lambda: _switches('Input'))
    outputs: Dict[str, bool] = field(default_factory=lambda: _switches('Output'))
    analog_inputs: Dict[str, AnalogInput] = field(
        default_factory=lambda: {'Analog_1': AnalogInput(voltage=2.5)})
    faults: Dict[str, ApplicationFault] = field(default_factory=dict)
    infos: Dict[str, Tuple[int, str]] = field(default_factory=dict)  # name -> maximum length, value
    io_sets: Dict[str, IoSet] = field(default_factory=dict)     # external I/O
    slots: Dict[int, Optional[Load]] = field(
        default_factory=lambda: dict.fromkeys(range(1, SLOTS + 1)))

    def load(self, slot: int, text: str, since: str) -> None:
        """Puts something into a slot."""
        self.slots[slot] = Load(text, since)

    def unload(self, slot: int) -> None:
        """Empties a slot."""
        self.slots[slot] = None
