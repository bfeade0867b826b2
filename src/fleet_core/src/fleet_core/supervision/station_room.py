"""The room at stations: to which of them a further robot may be sent."""
from __future__ import annotations

from typing import Callable, Dict, FrozenSet, Mapping, NamedTuple, Optional, Tuple

from fleet_core.supervision.missions import Mission
from fleet_core.work.queues import Others, has_place_for
from fleet_core.work.stations import Station


class Occupancy(NamedTuple):
    """The robots that take the places of a station and of its queue.

    robots  -- names of all of them
    waiters -- of each robot that goes to the station, the places that would do
    others  -- the robots there that do not make room
    leaving -- names of the robots that are to leave the station, because others wait for it
    """

    robots: Tuple[str, ...]
    waiters: Tuple[Tuple[int, ...], ...]
    others: Others
    leaving: FrozenSet[str] = frozenset()


class StationRoom:
    """For which missions there is still a place of their station, or a queue place.

    at          -- station of each place
    group_of    -- the group of which any place would do for the next stop of a mission; empty: none
    occupancies -- by the station's name
    """

    def __init__(self, at: Mapping[int, Station], group_of: Callable[[Mission], str],
                 occupancies: Mapping[str, Occupancy]) -> None:
        self._at, self._group_of = at, group_of
        self._occupancies: Dict[str, Occupancy] = dict(occupancies)

    @property
    def key(self) -> Tuple[Occupancy, ...]:
        """Is equal while the room is."""
        return tuple(self._occupancies.values())

    def copy(self) -> StationRoom:
        """The same room, to try what follows from more missions."""
        return StationRoom(self._at, self._group_of, self._occupancies)

    def full_station(self, mission: Mission) -> Optional[Station]:
        """The station of a mission's next stop if it is full with its queue; None: it is not."""
        station = self._at.get(mission.left[0])
        if station is None:
            return None
        taken = self._occupancies[station.name]
        places = self._places_for(mission, station)
        return None if has_place_for(places, taken.waiters, station, taken.others) else station

    def leaving(self, mission: Mission) -> FrozenSet[str]:
        """Robots that are to leave the station of a mission's next stop.

        Such a robot gets no mission there. If it stayed, it would pass all that wait.
        """
        station = self._at.get(mission.left[0])
        return frozenset() if station is None else self._occupancies[station.name].leaving

    def why_full(self, station: Station) -> str:
        """What a mission to a full station waits for, in words."""
        robots = ', '.join(self._occupancies[station.name].robots)
        return (f'station {station.name} is full with its queue' if not robots else
                f'station {station.name} is full with its queue: it waits for one of {robots} to '
                'leave')

    def robots_at(self, station: Station) -> Tuple[str, ...]:
        """Names of the robots that take the places of a station and of its queue."""
        return self._occupancies[station.name].robots

    def send(self, mission: Mission) -> None:
        """A robot is sent on a mission."""
        station = self._at.get(mission.left[0])
        if station is not None:
            taken = self._occupancies[station.name]
            self._occupancies[station.name] = taken._replace(
                waiters=(*taken.waiters, self._places_for(mission, station)))

    def _places_for(self, mission: Mission, station: Station) -> Tuple[int, ...]:
        return places_for(mission, station, self._group_of(mission))


NO_STATIONS = StationRoom({}, lambda _: '', {})


def places_for(mission: Mission, station: Station, group: str) -> Tuple[int, ...]:
    """The places of a station that would do for the next stop of a mission."""
    return station.places if group == station.name else mission.left[:1]
