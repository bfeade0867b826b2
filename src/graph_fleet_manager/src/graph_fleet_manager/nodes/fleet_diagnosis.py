"""What /diagnostics says of the fleet: robots that cannot work, and open missions."""
from __future__ import annotations

import time
from typing import Optional

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from graph_fleet_manager.supervision.fleet_view import RobotState, robot_views
from graph_fleet_manager.supervision.missions import MissionState
from graph_fleet_manager.supervision.supervisor import Supervisor


def report_fleet(supervisor: Optional[Supervisor], status: DiagnosticStatusWrapper) -> None:
    """Every robot's state; WARN when one cannot work."""
    if supervisor is None:
        status.summary(DiagnosticStatus.WARN, 'waiting for /graph')
        return
    views = robot_views(supervisor, time.monotonic())
    out = [view for view in views if view.state >= RobotState.OFFLINE]
    if supervisor.is_stopped:
        status.summary(DiagnosticStatus.WARN, 'the fleet is stopped')
    elif out:
        status.summary(DiagnosticStatus.WARN, f'{len(out)} of {len(views)} robots cannot work')
    else:
        status.summary(DiagnosticStatus.OK, f'{len(views)} robots')
    for view in views:
        waits = f': {view.waits_for}' if view.waits_for else ''
        status.add(view.name, f'{view.state.name}{waits}')


def report_missions(supervisor: Optional[Supervisor], status: DiagnosticStatusWrapper) -> None:
    """How many missions are open, and in which state."""
    states = [] if supervisor is None else [s.state for s in supervisor.open_statuses()]
    status.summary(DiagnosticStatus.OK, f'{len(states)} open missions')
    for state in (MissionState.PENDING, MissionState.ACTIVE, MissionState.PAUSED):
        status.add(state.name, str(states.count(state)))
