"""The fleet's status in /diagnostics: robots that cannot work, and open missions."""
from __future__ import annotations

import time
from typing import Optional, Sequence, Tuple

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from fleet_core.supervision.fleet_view import RobotState, RobotView, robot_views
from fleet_core.supervision.missions import MissionState
from fleet_core.supervision.resource_view import resource_views
from fleet_core.supervision.supervisor import Supervisor

_NAMED = 20  # most missions that are listed with their reason


def report_fleet(supervisor: Optional[Supervisor], trouble: str,
                 status: DiagnosticStatusWrapper) -> None:
    """Fills in the state of every robot.

    - ERROR while the journal cannot be written, or a robot is in a door that is not open for it.
      While there is no supervisor, `trouble` says why.
    - WARN while the fleet is stopped, there is no plan, or a robot cannot work or has no path.
    """
    if supervisor is None and trouble:
        status.summary(DiagnosticStatus.ERROR, f'no mission is accepted: {trouble}')
        return
    if supervisor is None:
        status.summary(DiagnosticStatus.WARN, 'waiting for /graph')
        return
    views = robot_views(supervisor, time.monotonic())
    status.summary(*_summary(supervisor, views))
    for view in views:
        waits = f': {view.waits_for.text}' if view.waits_for.text else ''
        status.add(view.name, f'{view.state.name}{waits}')


def _summary(supervisor: Supervisor, views: Sequence[RobotView]) -> Tuple[int, str]:
    """Returns the level of the whole fleet, and its most important trouble."""
    if supervisor.trouble:
        return DiagnosticStatus.ERROR, ('no mission is accepted and no robot gets anything new to '
                                        f'drive: {supervisor.trouble}')
    alarms = [alarm for view in resource_views(supervisor, time.monotonic())
              for alarm in view.alarms]
    if alarms:
        return DiagnosticStatus.ERROR, '; '.join(alarms)
    if supervisor.is_stopped:
        return DiagnosticStatus.WARN, supervisor.stop.words(time.time()).rstrip('.')
    plan, no_plan = supervisor.plan_executor.plan, supervisor.plan_executor.trouble
    if no_plan:
        return DiagnosticStatus.WARN, f'there is no plan: {no_plan}'
    out = [view for view in views if view.state >= RobotState.OFFLINE]
    if out:
        return DiagnosticStatus.WARN, f'{len(out)} of {len(views)} robots cannot work'
    stuck = [view.name for view in views if plan is not None and view.name in plan.unserved]
    if stuck:
        return DiagnosticStatus.WARN, f'no path at present for {", ".join(stuck)}'
    return DiagnosticStatus.OK, f'{len(views)} robots'


def report_missions(supervisor: Optional[Supervisor], status: DiagnosticStatusWrapper) -> None:
    """Fills in the number of open missions by state, and the reasons why the oldest ones wait."""
    missions = [] if supervisor is None else supervisor.book.stored_open
    states = [mission.state for mission in missions]
    status.summary(DiagnosticStatus.OK, f'{len(states)} open missions')
    for state in (state for state in MissionState if state.is_open):
        status.add(state.name, str(states.count(state)))
    for mission in [m for m in missions if m.reason][:_NAMED]:
        status.add(f'mission {mission.request_id}', f'{mission.state.name}: {mission.reason}')
