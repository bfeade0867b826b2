"""Finds places at which a robot is too near to places where other robots have loads.

A robot with a load may need more room than without it (`load_room`). Another robot may be too near:
at a queue place, at a dock, or at a place of a station. While it is there, the first robot gets
neither its load nor the last edge to its stop. It takes time to send the other robot away. If it
cannot leave, the load stays where it is.

What robots carry follows from the templates and the steps of jobs. A parameter may stand for any
place of a station, or for a place that a timetable names. Missions that are sent with their own
stops are not known in advance.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import (
    AbstractSet,
    Dict,
    FrozenSet,
    Iterable,
    Iterator,
    List,
    NamedTuple,
    Sequence,
    Set,
    Tuple,
)

from fleet_core.fleet import Fleet, RobotType
from fleet_core.geometry.exclusions import ROUNDING
from fleet_core.supervision.laden_types import LadenTypes
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import places_of
from fleet_core.work.stops import Condition, LoadEffect, StopKind, WorkStep
from fleet_core.work.templates import PARAMETER, Template
from trajectory_graph import Graph


@dataclass(frozen=True)
class TooNear:
    """A place at which a robot stands in the way of loads.

    other    -- the vertex of this place
    what     -- its kind and name, in words: a queue place, a place of a station, or a dock
    place    -- the vertex at which robots have loads
    loads    -- names of the types of these loads
    distance -- m between the two vertices
    needed   -- m that must be between robots at the two vertices
    is_queue -- True: robots wait at `place` with their loads; False: they take or bring loads there
    """

    other: int
    what: str
    place: int
    loads: FrozenSet[str]
    distance: float
    needed: float
    is_queue: bool = False

    @property
    def text(self) -> str:
        """One clause that says what is wrong and what to do."""
        does = 'waits with' if self.is_queue else 'takes or brings'
        return (f'{self.what} is {self.distance:.2f} m from vertex {self.place}, but robots need '
                f'{self.needed:.2f} m there with load {", ".join(sorted(self.loads))}: while a '
                f'robot stands at {self.other}, no other one {does} such a load at '
                f'{self.place}; put the two farther apart')


class _Stay(NamedTuple):
    """What robots carry at some places.

    comes -- types of load with which they arrive
    has   -- types of load that they carry there at some time
    """

    places: Tuple[int, ...]
    comes: FrozenSet[str]
    has: FrozenSet[str]


class _Stand(NamedTuple):
    """A vertex at which robots of some types may stand. `loads`: what they may carry there."""

    vertex: int
    what: str
    kinds: Sequence[RobotType]
    loads: AbstractSet[str]


def too_near(work: SiteWork, fleet: Fleet, graph: Graph) -> Tuple[TooNear, ...]:
    """Returns the places at which a robot would keep others from their loads.

    The robots count as the widest ones of the fleet.
    """
    if not any(load.radius for load in work.loads.values()):
        return ()
    laden = LadenTypes(work.loads, fleet.all_types)
    comes: Dict[int, Set[str]] = {}
    has: Dict[int, Set[str]] = {}
    for stay in _stays(work, graph):
        for place in stay.places:
            comes.setdefault(place, set()).update(stay.comes)
            has.setdefault(place, set()).update(stay.has)

    def reach(kinds: Sequence[RobotType], loads: AbstractSet[str]) -> float:
        return max(laden.laden(kind, loads).reach for kind in kinds)

    def are_near(place: int, loads: AbstractSet[str], stand: _Stand,
                 is_queue: bool) -> Iterator[TooNear]:
        ours, theirs = reach(fleet.all_types, loads), reach(stand.kinds, stand.loads)
        needed = ours + theirs + fleet.clearance
        is_wider = ours > reach(fleet.all_types, set()) or theirs > reach(stand.kinds, set())
        distance = math.dist(graph.vertex(place).position, graph.vertex(stand.vertex).position)
        if is_wider and distance < needed - ROUNDING:
            yield TooNear(stand.vertex, stand.what, place, frozenset(loads), distance, needed,
                          is_queue)

    found: List[TooNear] = []
    queues = _queues(work, fleet, comes)
    for place in sorted(one for one, loads in has.items() if loads):
        for stand in (*queues, *_stands(work, fleet, graph, place, has)):
            found += are_near(place, has[place], stand, False)
    for number, one in enumerate(queues):
        for other in queues[number + 1:]:
            first, second = (one, other) if one.loads else (other, one)
            if first.loads and first.vertex != second.vertex:
                found += are_near(first.vertex, first.loads, second, True)
    return tuple(found)


def _queues(work: SiteWork, fleet: Fleet, comes: Dict[int, Set[str]]) -> List[_Stand]:
    """Returns the queue places of all stations, with the loads that waiting robots bring."""
    return [_Stand(vertex, f'queue place {vertex} of station {station.name}', fleet.all_types,
                   {load for one in station.places for load in comes.get(one, ())})
            for station in work.stations.values() for vertex in station.queue]


def _stands(work: SiteWork, fleet: Fleet, graph: Graph, place: int,
            has: Dict[int, Set[str]]) -> Iterator[_Stand]:
    """Yields the places, except queue places, where others may stand while a robot is at `place`.
    """
    kinds = fleet.all_types
    for station in work.stations.values():
        if place not in station.places or station.capacity > 1:
            for vertex in _others(station.places, place, has):
                yield _Stand(vertex, f'place {vertex} of station {station.name}', kinds,
                             has.get(vertex, set()))
    for dock in (vertex.id for vertex in graph.vertices.values() if vertex.dock):
        charging = [kind for kind in kinds if kind.may_dock(dock)]
        if dock != place and charging:
            yield _Stand(dock, f'dock {dock}', charging, set())


def _others(places: Iterable[int], place: int, has: Dict[int, Set[str]]) -> List[int]:
    """Returns the places of a station that are to be compared with `place`.

    Omits vertices with lower ids if robots have loads there: the calls for them yield these pairs.
    """
    return [vertex for vertex in places
            if vertex != place and not (vertex < place and has.get(vertex))]


# -- what robots carry -----------------------------------------------------------------------------


def _stays(work: SiteWork, graph: Graph) -> Iterator[_Stay]:
    stations = tuple(place for one in work.stations.values() for place in one.places)
    for template in work.templates.values():
        yield from _stays_of(template, work, graph, stations)
    taken = frozenset(load for one in work.job_steps for load in _taken(one.steps))
    for one in work.job_steps:
        places = one.places or stations
        if one.kind is StopKind.PICKUP:
            yield _Stay(places, frozenset(), frozenset(_taken(one.steps)))
        else:
            yield _Stay(places, taken, taken)


def _stays_of(template: Template, work: SiteWork, graph: Graph,
              stations: Tuple[int, ...]) -> Iterator[_Stay]:
    """Returns what a robot carries at each stop of a template."""
    def places(at: str) -> Tuple[int, ...]:
        if not at.startswith(PARAMETER):
            return places_of(at, work.stations, graph)
        given = (dict(one.arguments)[at[len(PARAMETER):]] for one in work.timetables.values()
                 if one.template == template.name)
        return (*stations, *(place for word in given
                             for place in places_of(word, work.stations, graph)))

    count = 0
    carried: FrozenSet[str] = frozenset()
    all_taken: FrozenSet[str] = frozenset()
    for stop in template.stops:
        has = carried.union(_taken(stop.steps))
        yield _Stay(places(stop.at), carried, has)
        count += sum((step.load is LoadEffect.TAKES) - (step.load is LoadEffect.GIVES)
                     for step in stop.steps)
        carried, all_taken = has if count > 0 else frozenset(), all_taken | has
    for stop in template.on_cancel:
        if stop.condition is not Condition.EMPTY:
            yield _Stay(places(stop.at), all_taken, all_taken)


def _taken(steps: Sequence[WorkStep]) -> Iterator[str]:
    return (step.load_type for step in steps if step.load is LoadEffect.TAKES and step.load_type)
