"""The book of all missions: open ones, ended ones, and changes that are not stored yet."""
from __future__ import annotations

from collections import deque
from dataclasses import replace
from typing import Deque, Dict, Iterable, List, Mapping, Optional, Set, Tuple

from fleet_core.supervision.missions import (
    Acceptance,
    DeadlineState,
    Mission,
    MissionChange,
    MissionState,
    Request,
    RequestRefused,
    Status,
    short_name,
)
from fleet_core.supervision.pending_missions import PendingMissions
from fleet_core.work.dependencies import Dependency, Until

MOST_OPEN = 5000   # maximum number of open missions; more are a mistake, and delay urgent work
MOST_AFTER = 100   # maximum number of missions for which one mission may wait
REMEMBERED = 1000  # number of ended missions for which a repeated request is recognised


class MissionBook:
    """All open missions. Also the last mission of each id, if it is open or ended recently.

    stays -- by serial, the supervisor's time at which a mission's stay at a destination began

    It has one method for each change of a mission, so that the tables by serial, robot and
    successor agree.
    """

    def __init__(self, missions: Iterable[Mission] = (), next_serial: int = 1,
                 stays: Optional[Mapping[int, float]] = None) -> None:
        self._by_serial: Dict[int, Mission] = {}
        self._last: Dict[int, Mission] = {}
        self._by_robot: Dict[str, Mission] = {}
        self._ended: Deque[Mission] = deque()
        self._next = next_serial
        self.pending = PendingMissions()
        """The open missions that no robot serves."""
        self.changed: Set[int] = set()
        """Serials of missions whose status is to be stored and published."""
        self._begun_stays: Set[int] = set()
        self._followers: Dict[int, List[Mission]] = {}
        """The missions that wait for another mission, by the serial of that mission."""
        self.timed: Dict[int, Mission] = {}
        """The open missions with an earliest time or a deadline, by serial."""
        for mission in missions:
            mission.stored = mission.status
            mission.stays_since = (stays or {}).get(mission.serial)
            self._last[mission.request.id] = mission
            if mission.state.is_open:
                self._by_serial[mission.serial] = mission
                if mission.state is MissionState.PENDING:
                    self.pending.add(mission)
                if mission.robot:
                    self._by_robot[mission.robot] = mission
                self._note_conditions(mission)
            else:
                self._ended.append(mission)

    @property
    def open(self) -> List[Mission]:
        """The missions that have not ended, in the order of their acceptance."""
        return [mission for mission in list(self._by_serial.values()) if mission.state.is_open]

    @property
    def serving(self) -> Dict[str, Mission]:
        """The open missions that robots serve, by the robot's name."""
        return dict(self._by_robot)

    def is_open(self, serial: int) -> bool:
        """Returns whether a mission has not ended."""
        mission = self._by_serial.get(serial)
        return mission is not None and mission.state.is_open

    def is_pending(self, serial: int) -> bool:
        """Returns whether a mission waits for a robot."""
        mission = self._by_serial.get(serial)
        return mission is not None and mission.state is MissionState.PENDING

    @property
    def stored_open(self) -> List[Status]:
        """The stored status of each mission that has not ended."""
        return [mission.stored for mission in list(self._by_serial.values())
                if mission.stored is not None and mission.stored.state.is_open]

    def find(self, request_id: int) -> Optional[Mission]:
        """Returns the last mission with this id."""
        return self._last.get(request_id)

    def of_robot(self, name: str) -> Optional[Mission]:
        """Returns the open mission that a robot serves."""
        return self._by_robot.get(name)

    def add(self, request: Request, acceptance: Acceptance) -> Optional[Mission]:
        """Accepts a request. Returns None for a repeat. Raises RequestRefused."""
        last = self._last.get(request.id)
        if last is not None:
            if request.is_repeat_of(last.request, last.state.is_open):
                return None
            if last.state.is_open:
                raise RequestRefused(f'mission {request.id} is open with other content; choose '
                                     'another id')
        acceptance.check(request)
        if len(self._by_serial) >= MOST_OPEN:
            raise RequestRefused(f'{MOST_OPEN} missions are open; cancel some, or wait')
        request = replace(request, after=self._open_dependencies(request))
        mission = Mission(self._next, request, changed_by=request.requested_by)
        self._next += 1
        self._by_serial[mission.serial] = self._last[request.id] = mission
        mission.state, mission.reason = waits_as(request)
        self._note_conditions(mission)
        if mission.state is MissionState.PENDING:
            self.pending.add(mission)
        self.changed.add(mission.serial)
        return mission

    def _note_conditions(self, mission: Mission) -> None:
        for serial in {one.serial for one in mission.request.after}:
            self._followers.setdefault(serial, []).append(mission)
        if mission.request.earliest or mission.request.deadline:
            self.timed[mission.serial] = mission

    def _open_dependencies(self, request: Request) -> Tuple[Dependency, ...]:
        """Returns the open missions for which a request must wait, with their serials. Raises
        RequestRefused.

        All these missions were accepted before. So missions never wait for each other in a ring.
        """
        found: List[Dependency] = []
        if len(request.after) > MOST_AFTER:
            raise RequestRefused(f'it comes after more than {MOST_AFTER} missions')
        for one in request.after:
            other = self._last.get(one.mission)
            if other is None:
                raise RequestRefused(f'it must wait for mission {one.mission}, but there is no '
                                     'such mission')
            if other.state.is_open:
                found.append(replace(one, serial=other.serial))
            elif not _is_met(one, other):
                raise RequestRefused(f'it comes after mission {short_name(other.serial)}, '
                                     f'which has ended: {other.state.name}')
        return tuple(found)

    def _let_follow(self, mission: Mission) -> None:
        """Handles the end of a mission: a mission that waits for it goes on, or fails if it
        required another end.

        This is a loop, because recursion along a chain of missions may exceed Python's limit.
        """
        ended = deque((mission,))
        while ended:
            before = ended.popleft()
            for follower in self._followers.pop(before.serial, ()):
                if self.is_open(follower.serial):
                    self._is_over(follower, before)
                    if not follower.state.is_open:
                        ended.append(follower)

    def _is_over(self, mission: Mission, ended: Mission) -> None:
        """Updates `mission`, which waits for `ended`, after the end of `ended`."""
        after = mission.request.after
        if not all(_is_met(one, ended) for one in after if one.serial == ended.serial):
            self._set(mission, MissionState.FAILED,
                      f'it comes after mission {short_name(ended.serial)}, which has ended: '
                      f'{ended.state.name}')
            return
        after = tuple(one for one in after if one.serial != ended.serial)
        mission.request = replace(mission.request, after=after)
        self.changed.add(mission.serial)
        if mission.state is MissionState.BLOCKED:
            self._set(mission, *waits_as(mission.request, is_early=False))

    def withdraw(self, mission: Mission, before: Optional[Mission]) -> None:
        """Removes a mission that could not be stored. `before` is the last mission with its id."""
        self.changed.discard(mission.serial)
        self.timed.pop(mission.serial, None)
        del self._by_serial[mission.serial]
        if mission in self.pending:
            self.pending.remove(mission)
        del self._last[mission.request.id]
        if before is not None:
            self._last[mission.request.id] = before

    def set(self, mission: Mission, state: MissionState, reason: str = '',
            robot: Optional[str] = None) -> None:
        """Changes the state of a mission. A mission that has ended does not change any more."""
        was_open = mission.state.is_open
        self._set(mission, state, reason, robot)
        if was_open and not state.is_open:
            self._let_follow(mission)

    def _set(self, mission: Mission, state: MissionState, reason: str,
             robot: Optional[str] = None) -> None:
        if not mission.state.is_open:
            return
        robot = mission.robot if robot is None else robot
        if (mission.state, mission.reason, mission.robot) == (state, reason, robot):
            return
        if robot != mission.robot:
            self._by_robot.pop(mission.robot, None)
            if robot:
                self._by_robot[robot] = mission
        if (mission.state is MissionState.PENDING) != (state is MissionState.PENDING):
            (self.pending.add if state is MissionState.PENDING else self.pending.remove)(mission)
        mission.state, mission.reason, mission.robot = state, reason, robot
        self.changed.add(mission.serial)
        if not state.is_open:
            self.timed.pop(mission.serial, None)
            self._by_robot.pop(robot, None)

    def expect(self, mission: Mission, deadline: DeadlineState) -> None:
        """Notes whether a mission will be done by its deadline."""
        if deadline is not mission.deadline_state:
            mission.deadline_state = deadline
            self.changed.add(mission.serial)

    def change(self, mission: Mission, change: MissionChange) -> None:
        """Changes the priority of a mission, and its remaining destinations."""
        is_pending = mission in self.pending
        if is_pending:
            self.pending.remove(mission)
        mission.request, stays = mission.changed(change), mission.stays_since is not None
        if is_pending:
            self.pending.add(mission)
        self.changed.add(mission.serial)
        if change.destinations:
            mission.changes += 1
            if stays:
                self.reach(mission)

    def divert(self, mission: Mission, destinations: Tuple[int, ...],
               dwells: Tuple[float, ...], reached: int) -> None:
        """Replaces the destinations of a mission. The first `reached` of them count as visited."""
        mission.request = replace(mission.request, destinations=destinations, dwells=dwells)
        mission.reached = reached
        mission.changes += 1
        self.end_stay(mission)

    def end_stay(self, mission: Mission) -> None:
        """Notes that the mission does not stay at a destination any more.

        The destination is still to be visited.
        """
        mission.stays_since = None
        self._begun_stays.discard(mission.serial)
        self.changed.add(mission.serial)

    def stay(self, mission: Mission, now: float) -> None:
        """Notes that the mission stays at a destination from now on."""
        mission.stays_since = now
        self._begun_stays.add(mission.serial)

    def reach(self, mission: Mission, count: int = 1) -> None:
        """Counts `count` more destinations as visited.

        A mission without steps ends when all its destinations are visited.
        """
        mission.reached += count
        mission.stays_since = None
        self._begun_stays.discard(mission.serial)
        self.changed.add(mission.serial)
        if not mission.left and not mission.request.stops:
            self.set(mission, MissionState.SUCCEEDED)

    @property
    def is_changed(self) -> bool:
        """Whether any change is not stored yet."""
        return bool(self.changed or self._begun_stays)

    @property
    def changes(self) -> List[Mission]:
        """The missions with changes that are not stored yet."""
        return [self._by_serial[serial] for serial in sorted(self.changed)]

    def new_stays(self, now: float) -> Dict[int, float]:
        """Returns, by serial, how long ago (s) each stay that is not stored yet began."""
        return {serial: now - since for serial in sorted(self._begun_stays)
                for since in (self._by_serial[serial].stays_since,) if since is not None}

    def stored(self) -> None:
        """Notes that all changes are stored. Ended missions are kept only for their ids."""
        self._begun_stays.clear()
        changes, self.changed = self.changes, set()
        for mission in changes:
            mission.stored, mission.changed_by = mission.status, ''
            if not mission.state.is_open:
                self._by_serial.pop(mission.serial, None)
                self._ended.append(mission)
        while len(self._ended) > REMEMBERED:
            old = self._ended.popleft()
            if self._last.get(old.request.id) is old:
                del self._last[old.request.id]


def _is_met(one: Dependency, ended: Mission) -> bool:
    """Returns whether the end of a mission meets a dependency on it."""
    return one.until is Until.ENDED or ended.state is MissionState.SUCCEEDED


def waits_as(request: Request, is_early: bool = True) -> Tuple[MissionState, str]:
    """Returns the state of a mission that no robot serves, and what it waits for, in words.

    is_early -- the earliest time of the mission, if it has one, has not come yet
    """
    if request.earliest and is_early:
        return MissionState.PLANNED, 'it waits for its earliest time'
    if request.after:
        names = ', '.join(short_name(one.serial) for one in request.after)
        return MissionState.BLOCKED, f'it waits for the end of mission {names}'
    return MissionState.PENDING, ''
