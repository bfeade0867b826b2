"""Queues: which robots may go to a station now, and where the others wait.

A robot whose next stop is at a station is a *waiter* until it has left that stop. A waiter with a
*turn* may go to a place of the station. All others wait, and do not drive to the busy station:

    | the waiter                                           | turn | its target                     |
    |------------------------------------------------------|------|--------------------------------|
    | had a turn before, and there is still room for it    | yes  | its place                      |
    | claims the station, and a place is free for it       | yes  | its place                      |
    | is the first of the rest for which a place is free   | new  | the nearest free of its places |
    | has arrived at the queue                             | no   | a queue place, in this order   |
    | is on its way to the queue                           | no   | the queue places behind those  |
    | finds no queue place free                            | no   | where it is                    |

A mission that no robot serves yet is no waiter. While the station and its queue are full
(`has_place_for`), the mission gets no robot, because this robot would wait in the way of others and
do no other work. A waiter finds no queue place only if its mission has an earlier stop, or if the
queue was made shorter.

The rest are the waiters without a turn, in the order of the lower three rows. Robots that have
arrived come first, in the order of their arrival. Then come the robots on their way, in the order
in which they got a queue place. The last are the robots without a queue place, ordered by the
priority and age of their missions. So no robot overtakes another in the queue.

A turn is not a claim. A robot claims the station when it is granted the edges that lead there, as
it claims a door (`interlocking.claims`). Nothing here is stored: after a restart, robots with a
claim have their turns, and robots at queue places have arrived, in the order of the places.

Invariants, for each state after any events (`test_queues.py`):

- The robots with a turn and the other robots that claim the station do not exceed its capacity,
  unless the robots that claim it exceed it already.
- No two robots have the same target. No robot has a turn for a place where another one stands.
- A queue place is not used while a queue place before it is free.
- The order of the robots that have arrived never changes. While one of them waits, no robot behind
  it gets a turn, except for a place that does not suit the waiting robot.
- While a place is free and the station has room, no robot that may use the place waits.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import (
    AbstractSet,
    Dict,
    Iterable,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
    Union,
)

from fleet_core.work.chargers import Charger
from fleet_core.work.stations import Station


class Waiter(NamedTuple):
    """A robot whose next stop is at a station.

    places    -- vertices of the station that suit the robot, the nearest one first
    rank      -- rank of its mission; the mission with the lowest rank is served first
    ends_at   -- vertex at which the edges that it was granted end; None: it is between vertices
    is_inside -- it claims the station
    """

    robot: str
    places: Tuple[int, ...]
    rank: Tuple[int, int] = (0, 0)
    ends_at: Optional[int] = None
    is_inside: bool = False


@dataclass(frozen=True)
class Others:
    """The robots that are not waiters of a station, but take room or places there.

    inside -- number of these robots that claim the station
    at     -- vertices at which they stand, or at which their granted edges end
    kept   -- vertices of `at` where the robots do not make room
    """

    inside: int = 0
    at: AbstractSet[int] = frozenset()
    kept: AbstractSet[int] = frozenset()


@dataclass(frozen=True)
class Queue:
    """Where the waiters of a station go.

    turns   -- the place to which each robot with a turn goes
    arrived -- robots that have arrived at the queue, in the order of their arrival
    coming  -- robots on the way to a queue place, in the order in which they got one
    waits   -- the queue place of each robot without a turn; None: it waits where it is
    """

    turns: Mapping[str, int] = field(default_factory=dict)
    arrived: Tuple[str, ...] = ()
    coming: Tuple[str, ...] = ()
    waits: Mapping[str, Optional[int]] = field(default_factory=dict)


EMPTY_QUEUE = Queue()


class _Turns:
    """The turns that are given while a queue advances.

    places -- the place to which each robot with a turn goes
    """

    def __init__(self, station: Station, waiters: Mapping[str, Waiter], others: Others) -> None:
        self.places: Dict[str, int] = {}
        self._station, self._waiters, self._others = station, waiters, others
        self._inside = {name for name, one in waiters.items() if one.is_inside}

    @property
    def has_room(self) -> bool:
        """Whether one more robot that does not claim the station can get a turn."""
        return (len({*self.places, *self._inside}) + self._others.inside
                < self._station.capacity)

    def give(self, name: str, wanted: Optional[int] = None) -> None:
        """Gives a robot a turn for the wanted place or the nearest free one, if there is one."""
        stood_on = {one.ends_at for one in self._waiters.values() if one.robot != name}
        taken = {*stood_on, *self._others.at, *self.places.values()}
        free = [place for place in self._waiters[name].places if place not in taken]
        if free:
            self.places[name] = wanted if wanted in free else free[0]

    def keep(self, before: Mapping[str, int]) -> None:
        """Keeps earlier turns if there is room, and gives turns to robots that claim the station.
        """
        for name, place in before.items():
            if name in self._waiters and (name in self._inside or self.has_room):
                self.give(name, place)
        for one in sorted(self._waiters.values(), key=lambda one: one.rank):
            if one.is_inside and one.robot not in self.places:
                self.give(one.robot)

    def give_rest(self, order: Iterable[str]) -> None:
        """Gives turns, in the given order, to those robots that do not claim the station."""
        for name in order:
            if name not in self._inside and self.has_room:
                self.give(name)


def advanced(before: Queue, station: Station, waiters: Iterable[Waiter], others: Others) -> Queue:
    """Returns the queue of a station that follows `before`, with the robots that wait now."""
    known = {one.robot: one for one in waiters}
    turns = _Turns(station, known, others)
    turns.keep(before.turns)
    waiting = [one for name, one in known.items() if name not in turns.places]
    arrived = _arrived(before, station, waiting)
    order = [*arrived, *_behind(before, arrived, waiting)]
    turns.give_rest(order)
    rest = [name for name in order if name not in turns.places]
    free = [place for place in station.queue if place not in others.kept]
    waits: Dict[str, Optional[int]] = {**dict.fromkeys(rest), **dict(zip(rest, free))}
    return Queue(turns.places, tuple(name for name in arrived if name in waits),
                 tuple(name for name in rest if waits[name] is not None and name not in arrived),
                 waits)


def has_place_for(places: Sequence[int], waiters: Iterable[Sequence[int]],
                  station: Union[Station, Charger], others: Others) -> bool:
    """Returns whether one more waiter would find a place of the station or a queue place, in
    addition to all other waiters.

    If not, the waiter could only wait elsewhere, perhaps in the way. A charger has no queue.

    places  -- places that suit the new waiter
    waiters -- for each other waiter, the places that suit it
    others  -- `at` is ignored, because the robots at these places make room
    """
    wishes = [tuple(one) for one in (*waiters, places)]
    free = set(station.places) - set(others.kept)
    fixed = {one[0] for one in wishes if len(one) == 1} & free
    flexible = sum(len(one) > 1 for one in wishes)
    inside = min(station.capacity - others.inside,
                 len(fixed) + min(flexible, len(free) - len(fixed)))
    queue = station.queue if isinstance(station, Station) else ()
    queued = sum(place not in others.kept for place in queue)
    return len(wishes) <= max(inside, 0) + queued


def _arrived(before: Queue, station: Station, waiting: Sequence[Waiter]) -> List[str]:
    """Returns the robots that have arrived at the queue, in the order of their arrival."""
    names = {one.robot for one in waiting}
    arrived = [name for name in before.arrived if name in names]
    at = {one.robot: station.queue.index(one.ends_at) for one in waiting
          if one.ends_at in station.queue and one.robot not in arrived}
    return [*arrived, *sorted(at, key=lambda name: at[name])]


def _behind(before: Queue, arrived: Sequence[str], waiting: Sequence[Waiter]) -> List[str]:
    """Returns the robots that have not arrived: first the robots on their way, then those without a
    queue place.
    """
    away = {one.robot: one for one in waiting if one.robot not in arrived}
    coming = [name for name in (*before.turns, *before.coming) if name in away]
    outside = [name for name in away if name not in coming]
    return [*coming, *sorted(outside, key=lambda name: away[name].rank)]
