"""An independent witness of a running fleet, which checks the fleet with the robots' true
positions.

This module imports nothing of the fleet manager, and does not know its decisions. The caller
provides:

- the true positions of all robots,
- the requested missions and stops,
- the mission statuses that the fleet published,
- the faults and people that affect robots.

`broken` lists each promise that did not hold. Times are s of the caller's clock.
"""
from __future__ import annotations

import enum
import itertools
import math
import statistics
from dataclasses import dataclass, field
from typing import Dict, Iterable, List, Mapping, Optional, Sequence, Set, Tuple

Place = Tuple[float, float]

SKEW = 0.06  # m; robots move this far between the answers of two simulators
NEAR = 0.6  # m; a robot within this distance of a vertex has visited the vertex
CLOSE = 0.5  # m; if a moved robot has less free space to another one, missions of both may fail.
#              The second robot stops where it is, so the same holds for a third robot near it.
_LOOKS_AFTER = 2  # samples after a status until the robot's place at the status is known
STANDS = 0.15  # m; a stopped robot may still move by this much


class State(enum.IntEnum):
    """The state of a mission, with the numbers of `itrci_nav_msgs/MissionStatus`."""

    PENDING = 0
    ACTIVE = 1
    SUCCEEDED = 2
    FAILED = 3
    REFUSED = 4
    CANCELLED = 5
    PAUSED = 6
    CANCELLING = 7
    NEEDS_PERSON = 8
    BLOCKED = 9
    PLANNED = 10
    EXPIRED = 11

    @property
    def is_end(self) -> bool:
        """Whether no other state may follow."""
        return self in (State.SUCCEEDED, State.FAILED, State.REFUSED, State.CANCELLED,
                        State.EXPIRED)


@dataclass
class _Mission:
    destinations: Sequence[int]
    since: float
    state: Optional[State] = None  # None: no status was published yet
    robot: str = ''
    reached: int = 0
    is_cancelled: bool = False  # whether a person cancelled it
    served_by: Set[str] = field(default_factory=set)

    @property
    def is_open(self) -> bool:
        return self.state is None or not self.state.is_end


class Witness:
    """Judges a fleet; see the module's docstring.

    radii     -- radius (m) of each robot by its name
    clearance -- m that must stay free between two robots
    vertices  -- positions of the graph's vertices by id, in m
    grace     -- s; within this time after a stop, a robot that can be reached must stand
    """

    def __init__(self, radii: Mapping[str, float], clearance: float,
                 vertices: Mapping[int, Place], grace: float) -> None:
        self._radii, self._clearance, self._vertices = radii, clearance, vertices
        self._grace = grace
        self.broken: List[str] = []
        self.nearest = math.inf
        """The smallest free space (m) between any two robots so far, minus the clearance."""
        self.looks = 0
        self.driven: Dict[str, float] = dict.fromkeys(radii, 0.0)
        self._named: Set[Tuple[str, ...]] = set()
        self._missions: Dict[int, _Mission] = {}
        self._succeeded: Dict[int, int] = {}
        """For each mission whose visits are not checked yet: number of samples before it succeeded.
        """
        self._trails: Dict[str, List[Tuple[float, Place]]] = {name: [] for name in radii}
        self._carried: Set[str] = set()
        self._returned: Set[str] = set()
        self._stopped: Dict[str, float] = {}
        self._rest: Dict[str, Place] = {}
        self._cut: Dict[str, int] = {}
        self._troubled: Dict[str, float] = {}

    # -- actions of the caller ---------------------------------------------------------------------

    def ask(self, mission: int, destinations: Sequence[int], now: float) -> None:
        """Notes the request of a mission that the fleet can serve."""
        self._missions[mission] = _Mission(destinations, now)

    def cancel(self, mission: int) -> None:
        """Notes that a person cancelled the mission: from now on it may end as CANCELLED."""
        self._missions[mission].is_cancelled = True

    def stop(self, names: Iterable[str], now: float) -> None:
        """Notes that the fleet manager confirmed the stop of these robots."""
        for name in names:
            self._stopped.setdefault(name, now)

    def release(self, names: Iterable[str]) -> None:
        """Notes that the stop of these robots is released."""
        for name in names:
            self._stopped.pop(name, None)
            self._rest.pop(name, None)

    def cut(self, names: Iterable[str]) -> None:
        """Notes that these robots cannot be reached until `mend` was called as often as `cut`."""
        for name in names:
            self._cut[name] = self._cut.get(name, 0) + 1
            self._rest.pop(name, None)

    def mend(self, names: Iterable[str], now: float) -> None:
        """Ends one `cut`. If the robots are stopped, they have the whole time `grace` again."""
        for name in names:
            self._cut[name] -= 1
            if name in self._stopped:
                self._stopped[name] = now

    def trouble(self, name: str, now: float) -> None:
        """Notes that a fault affected the robot: its mission may fail because of this fault."""
        self._troubled[name] = now

    def carry(self, name: str, now: float) -> None:
        """Notes that a person moves the robot. Its distances are not checked until `bring_back` was
        called and the robot is far enough from all others.
        """
        self._carried.add(name)
        self._returned.discard(name)
        self.trouble(name, now)

    def bring_back(self, name: str) -> None:
        """Notes that the person has finished moving the robot."""
        self._returned.add(name)

    # -- observations ------------------------------------------------------------------------------

    def judge(self, now: float, first: Mapping[str, Place], second: Mapping[str, Place]) -> None:
        """Checks the positions of all robots, sampled twice in a row.

        Each simulator samples its robots at one moment, but the moments of two simulators differ
        slightly. Therefore two robots count as too near only if both samples show them too near.
        """
        self.looks += 1
        self._check_distances(first, second, now)
        for name, place in second.items():
            self._follow(name, place, now)
            self._check_rest(name, place, now)
        self._check_visits()

    def hear(self, mission: int, state: State, robot: str, reached: int, reason: str) -> None:
        """Checks a published status. Missions that the caller did not request are ignored."""
        asked = self._missions.get(mission)
        if asked is None:
            return
        before = asked.state
        if before is not None and before.is_end:
            if state is not before:
                self._break(f'mission {mission} ended as {before.name}, then it was {state.name}',
                            'end', str(mission))
            return
        if robot == asked.robot and reached < asked.reached:
            self._break(f'mission {mission} of {robot} had reached {asked.reached} destinations, '
                        f'then {reached}', 'reached', str(mission))
        asked.state, asked.robot, asked.reached = state, robot or asked.robot, reached
        if asked.robot:
            asked.served_by.add(asked.robot)
        self._check_end(mission, asked, reason)

    def end(self) -> None:
        """Reports each mission that is still open at the end of the run, because all missions had
        time to end.
        """
        self._check_visits(is_over=True)
        for mission, asked in self._missions.items():
            if asked.is_open:
                told = 'none' if asked.state is None else asked.state.name
                self._break(f'mission {mission} over {list(asked.destinations)} never ended; '
                            f'last state {told}, robot {asked.robot or "none"}', 'open',
                            str(mission))

    @property
    def open_missions(self) -> List[int]:
        """Ids of the requested missions that have not ended."""
        return [mission for mission, asked in self._missions.items() if asked.is_open]

    def ends(self) -> Dict[State, int]:
        """Returns the number of missions by the state in which they ended."""
        states = [asked.state for asked in self._missions.values() if not asked.is_open]
        return {state: states.count(state) for state in State if state.is_end}

    # -- judgements --------------------------------------------------------------------------------

    def _check_distances(self, first: Mapping[str, Place], second: Mapping[str, Place],
                         now: float) -> None:
        near: Set[str] = set()
        close: List[Tuple[str, str]] = []
        for one, other in itertools.combinations(sorted(second), 2):
            apart = self._radii[one] + self._radii[other] + self._clearance
            room = max(math.dist(look[one], look[other]) for look in (first, second)) - apart
            if room < 0.0:
                near.update((one, other))
            if room < CLOSE:
                close.append((one, other))
            if self._carried.isdisjoint((one, other)):
                self.nearest = min(self.nearest, room)
                if room < -SKEW:
                    self._break(f'{one} and {other} are too near by {-room:.2f} m, at '
                                f'{second[one]} and {second[other]}', 'near', one, other)
        self._trouble_around_carried(close, now)
        self._carried -= self._returned - near

    def _trouble_around_carried(self, close: Sequence[Tuple[str, str]], now: float) -> None:
        reached, before = set(self._carried), 0
        while len(reached) > before:
            before = len(reached)
            reached.update(name for pair in close if not reached.isdisjoint(pair) for name in pair)
        for name in reached & {name for pair in close for name in pair}:
            self.trouble(name, now)

    def _follow(self, name: str, place: Place, now: float) -> None:
        trail = self._trails[name]
        step = math.dist(trail[-1][1], place) if trail else math.inf
        if step > 0.02:
            trail.append((now, place))
            self.driven[name] += step if math.isfinite(step) else 0.0
        oldest = min((self._missions[one].since for one in (
            *self.open_missions, *self._succeeded)), default=now)
        while len(trail) > 2 and trail[1][0] < oldest - 1.0:
            del trail[0]

    def _check_rest(self, name: str, place: Place, now: float) -> None:
        since = self._stopped.get(name)
        if name in self._carried:
            self._rest.pop(name, None)  # a person moves this robot
            return
        if since is None or self._cut.get(name) or now < since + self._grace:
            return
        rest = self._rest.setdefault(name, place)
        if math.dist(rest, place) > STANDS:
            self._break(f'{name} drives {now - since:.1f} s after it was stopped: from {rest} to '
                        f'{place}', 'stop', name)

    def _check_end(self, mission: int, asked: _Mission, reason: str) -> None:
        if asked.state is State.SUCCEEDED:
            self._succeeded[mission] = self.looks
        elif asked.state is State.CANCELLED and not asked.is_cancelled:
            self._break(f'no person cancelled mission {mission}: {reason}', 'cancel', str(mission))
        elif asked.state is State.REFUSED:
            self._break(f'mission {mission} was refused: {reason}', 'refused', str(mission))
        elif asked.state is State.FAILED and not any(
                self._troubled.get(name, -math.inf) >= asked.since for name in asked.served_by):
            self._break(f'mission {mission} of {asked.robot} failed, though no fault affected it: '
                        f'{reason}', 'failed', str(mission))

    def _check_visits(self, is_over: bool = False) -> None:
        """Checks the visits of missions that have succeeded.

        The newest sample at the time of the status may be older than the last visit. So two more
        samples are awaited, and the robot's trail is kept until then.
        """
        for mission, looks in list(self._succeeded.items()):
            if self.looks < looks + _LOOKS_AFTER and not is_over:
                continue
            del self._succeeded[mission]
            asked = self._missions[mission]
            missed = self._missed(asked)
            if missed:
                self._break(f'mission {mission} over {list(asked.destinations)} succeeded, but '
                            f'{asked.robot} did not visit {missed} in this order',
                            'missed', str(mission))

    def _missed(self, asked: _Mission) -> List[int]:
        """Returns the first destination that the robot did not visit, and all later destinations.
        """
        trail = [place for _, place in self._trails.get(asked.robot, [])]
        left = list(asked.destinations)
        for before, place in zip(trail[:1] + trail, trail):
            while left and _distance(self._vertices[left[0]], before, place) <= (
                    NEAR + math.dist(before, place) / 2.0):
                del left[0]
        return left

    def _break(self, words: str, *name: str) -> None:
        if name not in self._named:
            self._named.add(name)
            self.broken.append(words)


def growth(samples: Sequence[float], share: float, least: float) -> Optional[Tuple[float, float]]:
    """Returns the medians of the second and the last quarter of the samples; None: no growth.

    The samples grew if the last median is larger than the earlier one by more than the fraction
    `share` (0..1), and by more than `least`. The first quarter is ignored, because caches fill
    then.
    """
    quarter = len(samples) // 4
    if not quarter:
        return None
    early = statistics.median(samples[quarter:2 * quarter])
    late = statistics.median(samples[-quarter:])
    return (early, late) if late > early * (1.0 + share) and late > early + least else None


def _distance(point: Place, start: Place, end: Place) -> float:
    """Returns the distance (m) from a point to the line segment between two other points."""
    length = math.dist(start, end)
    if length == 0.0:
        return math.dist(point, start)
    share = sum((p - s) * (e - s) for p, s, e in zip(point, start, end)) / length ** 2
    share = min(1.0, max(0.0, share))
    return math.dist(point, (start[0] + share * (end[0] - start[0]),
                             start[1] + share * (end[1] - start[1])))
