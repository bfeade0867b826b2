"""What a command does to an open mission, and to the robot that serves it."""
from __future__ import annotations

from dataclasses import replace
from typing import Mapping

from graph_fleet_manager.supervision.mission_book import MissionBook
from graph_fleet_manager.supervision.missions import (
    Acceptance,
    Change,
    Command,
    CommandCode,
    Mission,
    MissionState,
    Request,
    RequestRefused,
    Status,
)
from graph_fleet_manager.supervision.robots import ManagedRobot


def carry_out(command: Command, mission: Mission, book: MissionBook,
              robots: Mapping[str, ManagedRobot], requested_by: str = '') -> str:
    """Cancels, pauses, resumes, or ends a dwell; returns why not, or nothing."""
    name = mission.robot
    if command is Command.CANCEL:
        by = f' of {requested_by}' if requested_by else ''
        book.set(mission, MissionState.CANCELLED, f'cancelled on request{by}')
    elif command is Command.PAUSE:
        book.set(mission, MissionState.PAUSED)
    elif command is Command.RESUME:
        if mission.state is not MissionState.PAUSED:
            return f'Mission {mission.request.id} is not paused.'
        book.set(mission, MissionState.ACTIVE if name else MissionState.PENDING)
        if name:
            robots[name].comes_to_rest = False
    elif command is Command.RELEASE:
        if mission.stays_since is None:
            return f'Mission {mission.request.id} is not staying anywhere: nothing to release.'
        book.reach(mission)
    if name and command in (Command.CANCEL, Command.PAUSE):
        robots[name].comes_to_rest = True
    return ''


def modify(mission: Mission, change: Change, book: MissionBook, acceptance: Acceptance,
           robots: Mapping[str, ManagedRobot]) -> str:
    """Another priority, other destinations from now on; returns why not, a clause, or nothing.

    A robot that drives to others comes to rest, as it would for a cancelled mission, and goes on
    by a plan for the new ones.
    """
    try:
        acceptance.check_change(mission, change)
    except RequestRefused as refusal:
        return str(refusal)
    before = mission.left
    book.change(mission, change)
    if mission.robot and mission.state is MissionState.ACTIVE and mission.left != before:
        robots[mission.robot].comes_to_rest = True
    return ''


def refused(request: Request, reason: str) -> Status:
    """What is told of a request that becomes no mission."""
    return Status(request.id, MissionState.REFUSED, reason=reason, stamp=request.stamp)


def not_done(before: Status, command: Command, trouble: str) -> Status:
    """What is told of a command that cannot be carried out: the mission is as it was."""
    return replace(before, command=command, command_code=CommandCode.NOT_DONE,
                   reason=f'{command.name} is not done: {trouble}')


def not_stored(before: Status, command: Command, trouble: str) -> Status:
    """What is told of a command that was carried out, but is on no disk: the state that is."""
    return replace(before, command=command, command_code=CommandCode.NOT_STORED,
                   reason=f'{command.name} is carried out, but forgotten if the fleet manager '
                          f'ends before it can be stored: {trouble}')
