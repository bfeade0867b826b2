"""What a site says about work. `files.work_file` reads it."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import FrozenSet, Mapping

from fleet_core.work.devices import Device, StepDevice
from fleet_core.work.stations import Station
from fleet_core.work.templates import Template
from fleet_core.work.timetables import Timetable


@dataclass(frozen=True)
class SiteWork:
    """All that a site says about work. Each mapping is by name, in the order of the file.

    devices -- those through which edges lead
    step_devices -- those that carry out steps
    step_types -- the types of steps that the actors of the site know; empty: not said
    """

    stations: Mapping[str, Station] = field(default_factory=dict)
    devices: Mapping[str, Device] = field(default_factory=dict)
    step_devices: Mapping[str, StepDevice] = field(default_factory=dict)
    templates: Mapping[str, Template] = field(default_factory=dict)
    timetables: Mapping[str, Timetable] = field(default_factory=dict)
    step_types: FrozenSet[str] = frozenset()
