"""Stations, and the places that a word in a file or a command names."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Mapping, Tuple, Union

from trajectory_graph import Graph
from trajectory_graph.id_lists import listed


class StationKind(Enum):
    """How one of the places of a station is chosen for a mission."""

    STATION = 'station'   # the mission names the place
    GROUP = 'group'       # the places are equal: the fleet manager chooses one


@dataclass(frozen=True)
class Station:
    """Places at which robots work.

    places   -- vertices
    queue    -- vertices at which robots wait for the station, the nearest one first
    capacity -- number of robots that may be at its places
    """

    name: str
    places: Tuple[int, ...]
    queue: Tuple[int, ...] = ()
    capacity: int = 1
    kind: StationKind = StationKind.STATION


class UnknownPlace(ValueError):
    """A word that names no place, or more than one. The text is a clause that says what to do."""


Destination = Union[int, str]
"""The id of a vertex, or the name of a group of which the fleet manager chooses a place."""


def destination_of(word: str, stations: Mapping[str, Station], graph: Graph) -> Destination:
    """Returns the destination that a word names, see `places_of`. Raises UnknownPlace."""
    return group_of(word, stations) or places_of(word, stations, graph)[0]


def place_of(word: str, stations: Mapping[str, Station], graph: Graph) -> int:
    """Returns the one place that a word names. Raises UnknownPlace, also for a group."""
    if group_of(word, stations):
        raise UnknownPlace(f'{word} is a group; write `group: {word}` in place of `at`')
    return places_of(word, stations, graph)[0]


def places_of(word: str, stations: Mapping[str, Station], graph: Graph) -> Tuple[int, ...]:
    """Returns the places that a word names: one vertex, or the equal vertices of a group.

    The word is the name of a station, the id of a vertex, or a label that only one vertex has. If a
    word is both the name of a station and a label, it means the station. Raises UnknownPlace.
    """
    if word in stations:
        return _places_at(stations[word])
    if word.isdecimal():
        if int(word) not in graph.vertices:
            raise UnknownPlace(f'the graph has no vertex {word}')
        return (int(word),)
    found = _with_label(word, graph)
    if not found:
        raise UnknownPlace(f'no station and no vertex is named {word!r}; the stations are: '
                           f'{", ".join(stations) or "none"}')
    return (_only(word, found),)


def group_of(word: str, stations: Mapping[str, Station]) -> str:
    """Returns the group that a word names; empty: it names none."""
    return word if word in stations and stations[word].kind is StationKind.GROUP else ''


def _places_at(station: Station) -> Tuple[int, ...]:
    if len(station.places) > 1 and station.kind is not StationKind.GROUP:
        raise UnknownPlace(f'station {station.name} is no group; give one of its places: '
                           f'{listed(station.places)}')
    return station.places


def _with_label(label: str, graph: Graph) -> Tuple[int, ...]:
    return tuple(vertex.id for vertex in graph.vertices.values() if vertex.label == label)


def _only(label: str, found: Tuple[int, ...]) -> int:
    if len(found) > 1:
        raise UnknownPlace(f'vertices {listed(found)} have the label {label!r}; give '
                           'the id of one')
    return found[0]
