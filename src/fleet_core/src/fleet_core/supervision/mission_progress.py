"""Progress of missions: visited destinations, dwells, and robots that drop out."""
from __future__ import annotations

from dataclasses import replace
from typing import Iterator, Optional, Tuple

from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.missions import (
    Acceptance,
    Mission,
    MissionState,
    RequestRefused,
)
from fleet_core.supervision.robots import ManagedRobot


def follow(book: MissionBook, robot: ManagedRobot, now: float) -> bool:
    """Counts the destinations that a robot passed. Returns whether its mission ended.

    A destination with a dwell counts when the robot stands there and the dwell is over.
    """
    passed, robot.passed = robot.passed, []
    mission = book.of_robot(robot.name)
    if mission is None:
        return False
    for vertex in passed:
        if mission.left and mission.left[0] == vertex:
            _visit(book, mission, vertex)
    place = robot.position
    if place is not None:
        if place.vertex is not None:
            _visit(book, mission, place.vertex)
        if mission.state in (MissionState.ACTIVE, MissionState.CANCELLING):
            _dwell(book, mission, place.vertex, now)
    return not mission.state.is_open


def _visit(book: MissionBook, mission: Mission, vertex: int) -> None:
    count = mission.visits((vertex,))
    if count:
        book.reach(mission, count)


def _dwell(book: MissionBook, mission: Mission, vertex: Optional[int], now: float) -> None:
    """Begins or ends the dwell at a destination, according to the vertex where the robot stands.

    A robot may have left its destination during the dwell: it was pushed away, or the journal is an
    old one. Then it comes back, and its dwell begins anew. The work desk ends the dwells of
    missions with steps.
    """
    while mission.state.is_open and mission.left and mission.left[0] == vertex:
        if mission.stays_since is None:
            book.stay(mission, now)
        if mission.dwell_until is not None and now < mission.dwell_until:
            return
        book.reach(mission)
    if mission.stays_since is not None and not mission.request.stops:
        book.end_stay(mission)


def drop_out(book: MissionBook, robot: ManagedRobot) -> None:
    """Updates the mission of a robot that cannot work.

    - If the robot comes back by itself, the mission waits for it.
    - If the robot possibly carries the load of the mission, it keeps the mission.
    - If the robot needs a person, a mission that was not begun goes to another robot. A mission
      that only this robot may serve waits.
    - If the robot needs a person and the mission was begun, the mission has failed, because the
      robot's load is unknown.
    """
    mission = book.of_robot(robot.name)
    if mission is None or robot.outage is None:
        return
    reason = f'{robot.name}: {robot.why or robot.outage.value}'
    if not robot.outage.needs_person or mission.is_bound:
        book.set(mission, mission.state, reason)
    elif mission.reached or mission.stays_since is not None or mission.has_worked:
        book.set(mission, MissionState.FAILED, reason)
    elif mission.state is MissionState.CANCELLING:
        book.set(mission, MissionState.CANCELLED, reason)
    else:
        paused = mission.state is MissionState.PAUSED
        book.set(mission, MissionState.PAUSED if paused else MissionState.PENDING, reason, '')


def no_longer_possible(book: MissionBook, acceptance: Acceptance) -> Iterator[Tuple[Mission, str]]:
    """Yields open missions that cannot be completed any more, each with the reason.

    Fleet or graph may have changed while no supervisor ran.
    """
    for mission in book.open:
        if mission.robot and mission.robot not in acceptance.robots:
            yield mission, 'its robot is no longer in the fleet'
            continue
        request = mission.request
        try:
            acceptance.check(replace(request, destinations=mission.left or request.destinations,
                                     dwells=request.dwells[mission.reached:] if mission.left
                                     else request.dwells))
        except RequestRefused as refused:
            yield mission, str(refused)
