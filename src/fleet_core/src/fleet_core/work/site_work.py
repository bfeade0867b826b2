"""The data about work at a site. `files.work_file` reads them from the work file."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import FrozenSet, Mapping, NamedTuple, Tuple

from fleet_core.work.chargers import Charger
from fleet_core.work.devices import Device, StepDevice
from fleet_core.work.loads import LoadType
from fleet_core.work.stations import Station
from fleet_core.work.stops import StopKind, WorkStep
from fleet_core.work.templates import Template
from fleet_core.work.timetables import Timetable
from fleet_core.work.zones import Zone


class JobSteps(NamedTuple):
    """The steps at the stops of one kind. Other programs send the jobs that have these stops.

    places -- vertices of these stops; empty: all vertices that no other entry of this kind names
    """

    kind: StopKind
    steps: Tuple[WorkStep, ...]
    places: Tuple[int, ...] = ()


@dataclass(frozen=True)
class SiteWork:
    """All data about work at a site. The keys of each mapping are names, in the order of the file.

    devices -- devices through which edges lead
    step_devices -- devices that carry out steps
    step_types -- the types of steps that the actors of the site know; empty: the file lists none
    job_steps  -- the steps at pickups and drop-offs of jobs
    chargers -- chargers that the work file names
    """

    stations: Mapping[str, Station] = field(default_factory=dict)
    devices: Mapping[str, Device] = field(default_factory=dict)
    step_devices: Mapping[str, StepDevice] = field(default_factory=dict)
    templates: Mapping[str, Template] = field(default_factory=dict)
    timetables: Mapping[str, Timetable] = field(default_factory=dict)
    step_types: FrozenSet[str] = frozenset()
    job_steps: Tuple[JobSteps, ...] = ()
    chargers: Mapping[str, Charger] = field(default_factory=dict)
    zones: Mapping[str, Zone] = field(default_factory=dict)
    loads: Mapping[str, LoadType] = field(default_factory=dict)

    @property
    def names(self) -> FrozenSet[str]:
        """The names of all stations, devices, chargers and zones; no two of them have the same
        name.
        """
        return frozenset((*self.stations, *self.devices, *self.step_devices, *self.chargers,
                          *self.zones))

    def steps_of_job(self, place: int, kind: StopKind) -> Tuple[WorkStep, ...]:
        """Returns the steps at a stop of a job."""
        of_kind = [one for one in self.job_steps if one.kind is kind]
        return next((one.steps for named in (True, False) for one in of_kind
                     if (place in one.places if named else not one.places)), ())
