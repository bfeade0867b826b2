"""The state of each machine, and the robot for which it works, as published for the fleet."""
from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Dict, List, Mapping, NamedTuple, Optional, Tuple

from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.missions import Mission
from fleet_core.work.devices import StepDevice
from fleet_core.work.work import Work
from route_protocol.steps import StepReport

FRESH = 3.0  # s after which a report does not count any more; a machine reports each second


class MachineState(IntEnum):
    """What a machine does, as in itrci_nav_msgs/FleetMachine."""

    SILENT = 0    # it has not reported, or its reports are old
    FREE = 1      # it carries out no step
    WORKING = 2

    @property
    def words(self) -> str:
        """The state as people read it, on the page, in RViz and in lists."""
        return _WORDS[self]


_WORDS = {MachineState.SILENT: 'offline', MachineState.FREE: 'free',
          MachineState.WORKING: 'working'}


@dataclass(frozen=True)
class MachineView:
    """The published state of one machine.

    places -- the places where it stands according to the work file; if the file names none, the
              place where it works now; empty: unknown
    key    -- key of the step that it carries out; 0: none
    robot  -- the robot for which it works; empty: none, or no known mission has the step
    serial -- serial of the mission for which it works; 0: none, or no known mission has the step
    """

    name: str
    state: MachineState
    places: Tuple[int, ...] = ()
    key: int = 0
    robot: str = ''
    serial: int = 0


class _Heard(NamedTuple):
    """The newest report of a machine, and when it came."""

    report: StepReport
    at: float


class MachineReports:
    """The newest report of each machine. `now` is in s of a clock that never steps back.

    machines -- the machines of the site, by name
    """

    def __init__(self, machines: Mapping[str, StepDevice]) -> None:
        self._machines = machines
        self._heard: Dict[str, _Heard] = {}

    def newest(self, name: str) -> Optional[StepReport]:
        """Returns the newest report of a machine; None: none has come."""
        heard = self._heard.get(name)
        return None if heard is None else heard.report

    def keep(self, name: str, report: StepReport, now: float) -> None:
        """Keeps a report, which must be newer than all earlier reports."""
        self._heard[name] = _Heard(report, now)

    def views(self, book: MissionBook, works: Mapping[int, Work], now: float) -> List[MachineView]:
        """Returns all machines of the site, in the order of the work file.

        works -- of missions with steps, by their serials
        """
        return [self._view(one, book, works, now) for one in self._machines.values()]

    def _view(self, machine: StepDevice, book: MissionBook, works: Mapping[int, Work],
              now: float) -> MachineView:
        heard = self._heard.get(machine.name)
        if heard is None or now - heard.at > FRESH:
            return MachineView(machine.name, MachineState.SILENT, machine.at)
        key = next((one.key for one in heard.report.steps if not one.word.is_final), 0)
        if not key:
            return MachineView(machine.name, MachineState.FREE, machine.at)
        for name, mission in book.serving.items():
            place = _place_of_step(machine.name, key, mission, works)
            if place is not None:
                return MachineView(machine.name, MachineState.WORKING, machine.at or (place,), key,
                                   name, mission.serial)
        return MachineView(machine.name, MachineState.WORKING, machine.at, key)


def _place_of_step(device: str, key: int, mission: Mission,
                   works: Mapping[int, Work]) -> Optional[int]:
    """Returns the vertex of the stop of a mission that has this step.

    None: the mission does not have the step.
    """
    work = works.get(mission.serial)
    return next((work.stops[place.stop].place for place, step, own in work.steps
                 if step.device == device and own.key == key), None) if work else None
