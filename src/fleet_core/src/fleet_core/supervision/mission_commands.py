"""The effect of a command on an open mission, and on the robot that serves it."""
from __future__ import annotations

from dataclasses import replace
from typing import Mapping

from fleet_core.supervision.mission_book import MissionBook, waits_as
from fleet_core.supervision.missions import (
    Acceptance,
    CommandCode,
    CommandKind,
    Mission,
    MissionChange,
    MissionState,
    Request,
    RequestRefused,
    Status,
)
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.work_desk import WorkDesk


def carry_out(command: CommandKind, mission: Mission, book: MissionBook,
              robots: Mapping[str, ManagedRobot], desk: WorkDesk,
              requested_by: str = '') -> str:
    """Cancels, pauses or resumes a mission, or ends its dwell.

    Returns why this is impossible; empty: done.
    """
    name = mission.robot
    if command is CommandKind.CANCEL:
        by = f' of {requested_by}' if requested_by else ''
        reason = f'cancelled on request{by}'
        if desk.cancel(mission, reason):
            return ''
        book.set(mission, MissionState.CANCELLED, reason)
    elif command is CommandKind.PAUSE:
        book.set(mission, MissionState.PAUSED)
    elif command is CommandKind.RESUME:
        if mission.state is not MissionState.PAUSED:
            return f'Mission {mission.request.id} is not paused.'
        if not name:  # if its earliest time is past, `MissionTimes.follow` soon notes this
            book.set(mission, *waits_as(mission.request))
        else:
            book.set(mission, MissionState.ACTIVE)
            robots[name].comes_to_rest = False
    elif command is CommandKind.RELEASE:
        if mission.request.stops:
            return (f'Mission {mission.request.id} goes on when its steps have ended: nothing to '
                    'release.')
        if mission.stays_since is None:
            return f'Mission {mission.request.id} is not staying anywhere: nothing to release.'
        book.reach(mission)
    if name and command in (CommandKind.CANCEL, CommandKind.PAUSE):
        robots[name].comes_to_rest = True
    return ''


def modify(mission: Mission, change: MissionChange, book: MissionBook, acceptance: Acceptance,
           robots: Mapping[str, ManagedRobot], desk: WorkDesk) -> str:
    """Changes the priority, destinations or stops of a mission.

    Returns why the change is refused; empty: it is made.

    If the destinations change, the robot comes to rest, as for a cancelled mission. Then it goes on
    with a plan for the new destinations.
    """
    if mission.request.stops and change.destinations:
        return 'a mission with steps gets other stops, not destinations'
    if change.stops and not mission.request.stops:
        return 'a mission without steps gets other destinations, not stops'
    if change.first_stop and not change.stops:
        return 'it names a first stop to be replaced, but no stops'
    try:
        acceptance.check_change(mission, change)
    except RequestRefused as refusal:
        return str(refusal)
    problem = desk.change(mission, change) if change.stops else ''
    if problem:
        return problem
    before = mission.left
    book.change(mission, change)
    if mission.robot and mission.state is MissionState.ACTIVE and mission.left != before:
        robots[mission.robot].comes_to_rest = True
    return ''


def refused(request: Request, reason: str) -> Status:
    """Returns the status of a request that does not become a mission."""
    return Status(request.id, MissionState.REFUSED, reason=reason, stamp=request.stamp)


def not_done(before: Status, command: CommandKind, trouble: str) -> Status:
    """Returns the status after a command that cannot be carried out: the mission is unchanged."""
    return replace(before, command=command, command_code=CommandCode.NOT_DONE,
                   reason=f'{command.name} is not done: {trouble}')


def not_stored(before: Status, command: CommandKind, trouble: str) -> Status:
    """Returns the status after a command that was carried out but could not be stored."""
    return replace(before, command=command, command_code=CommandCode.NOT_STORED,
                   reason=f'{command.name} is carried out, but will be lost if the fleet '
                          f'manager ends before it can be stored: {trouble}')
