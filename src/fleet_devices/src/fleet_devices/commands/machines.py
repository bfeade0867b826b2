"""The machines in `device list`: the state that each machine reports, and the robot it works for.

Only the fleet manager knows the robot. If no fleet manager runs, the list does not name robots.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence

import rospy

from fleet_core.supervision.machine_view import FRESH, MachineState, MachineView
from fleet_core.supervision.missions import short_name
from fleet_devices.commands.ages import age
from graph_fleet_manager.commands.tables import table_with_notes
from graph_fleet_manager.messages.resources import machine_of
from itrci_nav_msgs.msg import FleetState, StepStates
from route_protocol.step_messages import WrongStepMessage, step_report_of
from route_protocol.steps import ShownStep, StepCode, StepReport, Word

_TOPIC = '/devices/', '/step_states'


@dataclass(frozen=True)
class ListedMachine:
    """A machine, as the list shows it.

    report  -- its newest report; None: no report came
    read_at -- when this report was made, s since 1970
    told    -- the fleet manager's view of it; None: no fleet manager runs, or it lacks the machine
    """

    name: str
    report: Optional[StepReport] = None
    read_at: float = 0.0
    told: Optional[MachineView] = None

    def state(self, now: float) -> MachineState:
        """Returns its state, according to its own report."""
        if self.report is None or now - self.read_at > FRESH:
            return MachineState.SILENT
        return MachineState.FREE if self.running is None else MachineState.WORKING

    @property
    def running(self) -> Optional[ShownStep]:
        """The step that it carries out."""
        return next((one for one in self._steps if not one.word.is_final), None)

    @property
    def last(self) -> Optional[ShownStep]:
        """The step that it carries out, or carried out last."""
        steps = self._steps
        return max(steps, key=lambda one: one.key) if steps else None

    @property
    def _steps(self) -> Sequence[ShownStep]:
        return () if self.report is None else self.report.steps

    @property
    def serves(self) -> str:
        """The robot for which the machine works, and the mission; '-': no robot, or not known."""
        step, told = self.running, self.told
        if step is None or told is None or told.key != step.key or not told.robot:
            return '-'
        return f'{told.robot} ({short_name(told.serial)})'


def machine_topics() -> List[str]:
    """Returns the topics on which machines report, from the ROS master."""
    return [name for name, kind in rospy.get_published_topics('/devices')
            if kind == StepStates._type and machine_of_topic(name)]


def machine_of_topic(topic: str) -> str:
    """Returns the name of the machine that reports on a topic; empty: it is another topic."""
    begin, end = _TOPIC
    name = topic[len(begin):-len(end)]
    return name if topic == f'{begin}{name}{end}' and '/' not in name else ''


def listed_machines(reports: Mapping[str, StepStates], state: Optional[FleetState],
                    ) -> List[ListedMachine]:
    """Returns all machines that report, or that the fleet manager knows, sorted by name.

    reports -- the newest report of each machine
    state   -- the state of the fleet; None: no fleet manager runs
    """
    told = {} if state is None else {one.name: machine_of(one) for one in state.machines}
    return [_machine(name, reports.get(name), told.get(name)) for name in sorted({*reports, *told})]


def _machine(name: str, message: Optional[StepStates],
             told: Optional[MachineView]) -> ListedMachine:
    if message is None:
        return ListedMachine(name, told=told)
    try:
        report = step_report_of(message)
    except WrongStepMessage:
        return ListedMachine(name, told=told)
    return ListedMachine(name, report, message.header.stamp.to_sec(), told)


def machine_table(machines: Iterable[ListedMachine], now: float) -> str:
    """Returns the machines as a table. If the last step of a machine failed, its text is below it.
    """
    rows, notes = [], []
    for one in machines:
        last = one.last
        rows.append((one.name, one.state(now).name,
                     'never' if one.report is None else age(one.read_at, now),
                     '-' if last is None else str(last.key),
                     '-' if last is None else last.word.name, one.serves))
        notes.append('' if last is None or last.word in (Word.RUNNING, Word.DONE) else last.text)
    return table_with_notes(('machine', 'does', 'read', 'step', 'which is', 'works for'), rows,
                            notes)


def machine_values(machine: ListedMachine, now: float) -> Dict[str, Any]:
    """Returns a machine as values for JSON."""
    running, told = machine.running, machine.told
    is_told = running is not None and told is not None and told.key == running.key
    return {'machine': machine.name, 'state': machine.state(now).name,
            'read': machine.read_at or None, 'key': None if running is None else running.key,
            'robot': (told.robot or None) if is_told and told is not None else None,
            'mission_serial': (told.serial or None) if is_told and told is not None else None,
            'steps': [{'key': one.key, 'state': one.word.name, 'code': None
                       if one.code is StepCode.NONE else one.code.name, 'text': one.text or None}
                      for one in (machine.report.steps if machine.report else ())]}
