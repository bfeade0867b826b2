"""The robot's condition for /diagnostics: battery, localization, emergency stop, motors, faults."""
from __future__ import annotations

import time
from typing import Dict, Optional

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from omron_arcl import ActivityKind, Reply, printable, read_activity
from omron_arcl.replies import (
    DockingStatus,
    EStop,
    Fault,
    LocalizationScore,
    Motors,
    OneLineStatus,
    StateOfCharge,
    StatusText,
)
from omron_ld90.operator.localizing import LOW_SCORE

LOW_CHARGE = 25.0  # %; below this, the robot drives to its dock by itself, by default
EMPTY_CHARGE = 10.0  # %; below this, the robot itself warns
OLD = 10.0  # s after the last reply until /diagnostics reports that none comes


class RobotHealth:
    """Keeps the last value of each condition; call `observe` with every reply."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Resets all values to unknown, as at the start and after the link broke."""
        self._observed: Optional[float] = None
        self._status = ''
        self._lost = False
        self._charge: Optional[float] = None
        self._score: Optional[float] = None
        self._docking = ''
        self._emergency_stop = False
        self._motors: Optional[bool] = None
        self._faults: Dict[str, Fault] = {}

    def observe(self, reply: Reply) -> None:
        """Takes the robot's condition from a reply."""
        if isinstance(reply, OneLineStatus):
            self._observe_status(reply.status)
            for part in (reply.state_of_charge, reply.localization_score):
                if part is not None:
                    self.observe(part)
        elif isinstance(reply, StatusText):
            self._observe_status(reply.text)
        elif isinstance(reply, StateOfCharge):
            self._charge = reply.percent
        elif isinstance(reply, LocalizationScore):
            self._score = reply.score
        elif isinstance(reply, DockingStatus):
            self._docking = f'{reply.docking.value}, charge {printable(reply.charge)}'
        elif isinstance(reply, EStop):
            self._emergency_stop = reply.pressed or self._emergency_stop
            self._motors = False
        elif isinstance(reply, Motors):
            self._motors = reply.enabled
            self._emergency_stop = self._emergency_stop and not reply.enabled
        elif isinstance(reply, Fault):
            if reply.cleared:
                self._faults.pop(reply.name, None)
            elif len(self._faults) < 50:
                self._faults[reply.name] = reply
        else:
            return
        self._observed = time.monotonic()

    def _observe_status(self, text: str) -> None:
        activity = read_activity(text)
        self._status = printable(text)
        self._lost = activity.kind is ActivityKind.LOST
        self._emergency_stop = activity.kind is ActivityKind.EMERGENCY_STOP
        if isinstance(activity.reply, (EStop, Motors, DockingStatus)):
            self.observe(activity.reply)

    def diagnose(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fills in a status with the worst condition, as a task for diagnostic_updater."""
        status.summary(DiagnosticStatus.OK, self._status or 'well')
        if self._observed is None or time.monotonic() - self._observed > OLD:
            status.summary(DiagnosticStatus.STALE, 'no recent line from the robot')
            return status
        for bad, level, message in (
                (self._emergency_stop, DiagnosticStatus.ERROR, 'emergency stop'),
                (self._motors is False and not self._emergency_stop, DiagnosticStatus.WARN,
                 'motors disabled'),
                (self._lost, DiagnosticStatus.ERROR,
                 'the robot does not know where it is'),
                (bool(self._faults), DiagnosticStatus.ERROR,
                 printable('faults: ' + ', '.join(list(self._faults)))),
                (_below(self._score, LOW_SCORE), DiagnosticStatus.WARN, 'poorly localized'),
                (_below(self._charge, EMPTY_CHARGE), DiagnosticStatus.ERROR, 'battery empty'),
                (_below(self._charge, LOW_CHARGE), DiagnosticStatus.WARN, 'battery low')):
            if bad:
                status.mergeSummary(level, message)
        status.add('status', self._status)
        status.add('docking', self._docking or 'unknown')
        status.add('emergency stop', str(self._emergency_stop))
        status.add('motors', {None: 'unknown', True: 'enabled', False: 'disabled'}[self._motors])
        status.add('state of charge [%]', _shown(self._charge))
        status.add('localization score', _shown(self._score))
        return status


def _below(value: Optional[float], limit: float) -> bool:
    return value is not None and value < limit


def _shown(value: Optional[float]) -> str:
    return 'unknown' if value is None else str(value)
