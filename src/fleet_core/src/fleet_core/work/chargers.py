"""Chargers: which robots may go to them now, and to which of their places.

A robot that is to charge is a *candidate* until it may leave the charger. It *needs* to charge, or
it only *tops up*, because it has nothing to do. A candidate with a *turn* may go to a place of a
charger. All others wait, and do not drive to a charger for which they have no turn.

Turns are given in the order of these rows, in each row to the emptiest robot first:

    | the candidate                             | its turn is for                               |
    |-------------------------------------------|-----------------------------------------------|
    | needs to charge, and claims a charger     | the place of its last turn, if it is free;    |
    | needs to charge, and had a turn before    | otherwise the nearest free place              |
    | needs to charge                           |                                               |
    | tops up, and had a turn before            | the same, but no place to which a mission     |
    | tops up                                   | goes                                          |

So a robot that tops up yields to robots that need to charge, and to missions. A robot chooses again
as long as it waits. On its way it chooses again if its place is not free any more.

A turn is not a claim. A robot claims the charger when it is granted the edges that lead there, as
it claims a door (`interlocking.claims`).

Invariants, for each state after any events (`test_chargers.py`):

- No two robots have a turn for the same place. No robot has a turn for a place in which another one
  stays.
- The robots with a turn for a charger and the other robots that stay in it do not exceed its
  capacity, unless the robots that stay exceed it already.
- While a place is free and its charger has room, no robot that needs to charge and may use the
  place waits.
- No robot that needs to charge waits for a place for which a robot that tops up has a turn.
- A robot keeps its turn until it may leave the charger, another robot stays in the place or claims
  the charger, or the place does not suit the robot any more.
"""
from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import AbstractSet, Dict, Iterable, Mapping, NamedTuple, Optional, Tuple


@dataclass(frozen=True)
class Charger:
    """Docks at which robots charge. They are equal: any of them suits a robot.

    places   -- dock vertices
    capacity -- number of robots that may be at its places
    """

    name: str
    places: Tuple[int, ...]
    capacity: int = 1


class Candidate(NamedTuple):
    """A robot that is to charge.

    places    -- docks that suit the robot, the nearest one first
    charge    -- state of charge of its battery, from 0 to 1
    needs     -- it needs to charge; False: it only tops up
    had       -- the place of its last turn; None: it had no turn
    is_inside -- it claims the charger of the place that it prefers
    """

    robot: str
    places: Tuple[int, ...]
    charge: float = 0.0
    needs: bool = True
    had: Optional[int] = None
    is_inside: bool = False

    @property
    def preferred(self) -> Tuple[int, ...]:
        """Its places; the place of its last turn comes first."""
        if self.had not in self.places:
            return self.places
        return (self.had, *(place for place in self.places if place != self.had))


@dataclass(frozen=True)
class Occupied:
    """The places and the room at chargers that are taken by robots that are no candidates.

    kept   -- places in which such robots stay
    inside -- by the name of a charger, how many such robots stay in it
    wanted -- places to which missions go
    """

    kept: AbstractSet[int] = frozenset()
    inside: Mapping[str, int] = field(default_factory=dict)
    wanted: AbstractSet[int] = frozenset()


def turns_of(chargers: Iterable[Charger], candidates: Iterable[Candidate],
             occupied: Occupied) -> Dict[str, int]:
    """Returns the names of the robots that have a turn now, each with its place at a charger."""
    at = {place: one for one in chargers for place in one.places}
    taken = Counter(occupied.inside)
    turns: Dict[str, int] = {}

    def is_free(place: int, needs: bool) -> bool:
        charger = at[place]
        return (place not in occupied.kept and place not in turns.values()
                and taken[charger.name] < charger.capacity
                and (needs or place not in occupied.wanted))

    for one in sorted(candidates, key=_rank):
        place = next((place for place in one.preferred if is_free(place, one.needs)), None)
        if place is not None:
            turns[one.robot] = place
            taken[at[place].name] += 1
    return turns


def _rank(one: Candidate) -> Tuple[bool, bool, bool, float]:
    """Returns the rank of a candidate: the candidate with the lowest rank gets a turn first."""
    return not one.needs, not (one.needs and one.is_inside), one.had is None, one.charge
