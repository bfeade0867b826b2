"""The fleet's status in /diagnostics: robots that cannot work, and open missions."""
from __future__ import annotations

import time
from typing import Optional, Tuple

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from fleet_core.supervision.fleet_view import FleetView, RobotState
from fleet_core.supervision.missions import MissionState
from fleet_core.supervision.supervisor import Supervisor

_NAMED = 20  # missions that are listed with their reason, at most


def report_fleet(view: Optional[FleetView], trouble: str,
                 status: DiagnosticStatusWrapper) -> None:
    """Fills in the state of every robot. `view` is None while there is no supervisor.

    - ERROR while the journal cannot be written, a robot is in a door that is not open for it, or
      `trouble` (a clause) prevents the start of the supervisor.
    - WARN while there is no graph or no plan, the fleet is stopped, or a robot cannot work or has
      no path.
    """
    if view is None and trouble:
        status.summary(DiagnosticStatus.ERROR, f'no mission is accepted: {trouble}')
        return
    if view is None:
        status.summary(DiagnosticStatus.WARN, 'waiting for /graph')
        return
    status.summary(*_summary(view))
    for robot in view.robots:
        waits = f': {robot.waits_for.text}' if robot.waits_for.text else ''
        status.add(robot.name, f'{robot.state.name}{waits}')


def _summary(view: FleetView) -> Tuple[int, str]:
    """Returns the level of the whole fleet, and a text about the most important trouble."""
    if view.trouble:
        return DiagnosticStatus.ERROR, ('no mission is accepted and no robot gets anything new to '
                                        f'drive: {view.trouble}')
    alarms = [alarm for resource in view.resources for alarm in resource.alarms]
    if alarms:
        return DiagnosticStatus.ERROR, '; '.join(alarms)
    if view.stop.is_in_force:
        return DiagnosticStatus.WARN, view.stop.words(time.time()).rstrip('.')
    if view.no_plan:
        return DiagnosticStatus.WARN, f'there is no plan: {view.no_plan}'
    out = sum(robot.state >= RobotState.OFFLINE for robot in view.robots)
    if out:
        return DiagnosticStatus.WARN, f'{out} of {len(view.robots)} robots cannot work'
    stuck = [robot.name for robot in view.robots if robot.name in view.unserved]
    if stuck:
        return DiagnosticStatus.WARN, f'no path at present for {", ".join(stuck)}'
    return DiagnosticStatus.OK, f'{len(view.robots)} robots'


def report_missions(supervisor: Optional[Supervisor], status: DiagnosticStatusWrapper) -> None:
    """Fills in the number of open missions by state, and the reasons why the oldest missions wait.
    """
    missions = [] if supervisor is None else supervisor.book.stored_open
    states = [mission.state for mission in missions]
    status.summary(DiagnosticStatus.OK, f'{len(states)} open missions')
    for state in (state for state in MissionState if state.is_open):
        status.add(state.name, str(states.count(state)))
    for mission in [m for m in missions if m.reason][:_NAMED]:
        status.add(f'mission {mission.request_id}', f'{mission.state.name}: {mission.reason}')
