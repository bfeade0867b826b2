"""The room at stations and chargers: whether a further robot may be sent there for a mission."""
from __future__ import annotations

from typing import Callable, Dict, FrozenSet, Mapping, NamedTuple, Optional, Tuple, Union

from fleet_core.supervision.missions import Mission
from fleet_core.work.chargers import Charger
from fleet_core.work.queues import Others, has_place_for
from fleet_core.work.stations import Station

Target = Union[Station, Charger]
"""A station or a charger: both have places to which missions go."""


class Occupancy(NamedTuple):
    """The robots that take the places of a station and of its queue, or of a charger.

    robots  -- names of all these robots
    waiters -- for each robot that goes there for a mission, the places where its stop may be
    others  -- the robots there that do not make room
    leaving -- names of the robots that are to leave the station, because others wait for it
    doing   -- what each robot at a charger does there, in words that follow the robot's name
    """

    robots: Tuple[str, ...]
    waiters: Tuple[Tuple[int, ...], ...]
    others: Others
    leaving: FrozenSet[str] = frozenset()
    doing: Tuple[str, ...] = ()


class StationRoom:
    """The free places for missions at stations, in their queues, and at chargers.

    at          -- station or charger of each place
    group_of    -- returns the group of a mission's next stop, which may be at any place of the
                   group; empty: the next stop has no group
    occupancies -- by the name of the station or charger
    """

    def __init__(self, at: Mapping[int, Target], group_of: Callable[[Mission], str],
                 occupancies: Mapping[str, Occupancy]) -> None:
        self._at, self._group_of = at, group_of
        self._occupancies: Dict[str, Occupancy] = dict(occupancies)

    @property
    def key(self) -> Tuple[Occupancy, ...]:
        """A value that stays equal as long as the room does not change."""
        return tuple(self._occupancies.values())

    def copy(self) -> StationRoom:
        """Returns a copy in which the effect of more missions can be tried."""
        return StationRoom(self._at, self._group_of, self._occupancies)

    def full(self, mission: Mission) -> Optional[Target]:
        """Returns the station or charger of a mission's next stop if it is full; else None."""
        station = self._at.get(mission.left[0])
        if station is None:
            return None
        taken = self._occupancies[station.name]
        places = self._places_for(mission, station)
        return None if has_place_for(places, taken.waiters, station, taken.others) else station

    def leaving(self, mission: Mission) -> FrozenSet[str]:
        """Returns robots that are to leave the station of a mission's next stop.

        Such a robot gets no mission there. If it stayed, it would go before all robots that wait.
        """
        station = self._at.get(mission.left[0])
        return frozenset() if station is None else self._occupancies[station.name].leaving

    def why_full(self, station: Target) -> str:
        """Returns, in words, what a mission waits for if its station or charger is full."""
        taken = self._occupancies[station.name]
        if isinstance(station, Charger):
            users = map('{}, {}'.format, taken.robots, taken.doing)
            return f'charger {station.name} is in use by {"; ".join(users)}'
        robots = ', '.join(taken.robots)
        return (f'station {station.name} is full with its queue' if not robots else
                f'station {station.name} is full with its queue: it waits for one of {robots} to '
                'leave')

    def robots_at(self, station: Target) -> Tuple[str, ...]:
        """Returns the names of the robots that take the places of a station with its queue,
        or of a charger.
        """
        return self._occupancies[station.name].robots

    def send(self, mission: Mission) -> None:
        """Notes that a robot is sent on a mission."""
        station = self._at.get(mission.left[0])
        if station is not None:
            taken = self._occupancies[station.name]
            self._occupancies[station.name] = taken._replace(
                waiters=(*taken.waiters, self._places_for(mission, station)))

    def _places_for(self, mission: Mission, station: Target) -> Tuple[int, ...]:
        return places_for(mission, station, self._group_of(mission))


NO_STATIONS = StationRoom({}, lambda _: '', {})


def places_for(mission: Mission, station: Target, group: str) -> Tuple[int, ...]:
    """Returns the places of a station at which the next stop of a mission may take place."""
    return station.places if group == station.name else mission.left[:1]
