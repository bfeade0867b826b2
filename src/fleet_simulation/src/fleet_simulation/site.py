"""The simulated site: its graph, robot types and demand, and fleets of any size."""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache, partial
from math import inf
from typing import Dict, FrozenSet, Set, Tuple

from fleet_core.files.errors import FileError
from fleet_core.fleet import Fleet, Robot, RobotType
from fleet_core.planning.parking import WellFormedSets
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.site.survey import parking_for_all
from fleet_core.supervision.settings import RobotSettings
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import places_of
from fleet_core.work.templates import PARAMETER
from fleet_core.work.timetables import Timetable
from fleet_simulation.demand import Demand
from fleet_simulation.demand_file import Wanted
from fleet_simulation.driven_robot import Delays
from fleet_simulation.step_times import WorkTimes
from trajectory_graph import Graph


class WrongSite(Exception):
    """The site cannot be simulated; the text is one sentence that says why and what to do."""


class OrderPolicy(Enum):
    """How the order in which robots use shared places changes while robots are late."""

    FIXED = 'fixed'
    SWITCHING = 'switching'    # reverses the order in a corridor if the fleet then finishes sooner
    REPLANNING = 'replanning'  # makes all plans anew every 5 s


@dataclass(frozen=True)
class StudiedSite:
    """All inputs of a run, except the number of robots and the seed.

    settings -- of each robot in the fleet file, by its name
    starts   -- ids of vertices on which robots of all types may stand for ever. If the fleet is
                larger than in the fleet file, its robots begin on these vertices, evenly spread
    parking  -- ids of the vertices on which the planner may park robots
    latency  -- virtual s until the planner answers
    rounds   -- rounds in which the planner improves each plan
    order    -- how the order on shared places changes while robots are late
    work     -- the content of the work file. The supervisor runs its timetables
    times    -- how long steps and devices take
    begin    -- local time at which a run begins, in minutes since the beginning of Monday
    """

    graph: Graph
    fleet: Fleet
    settings: Dict[str, RobotSettings]
    demand: Demand
    delays: Delays
    starts: Tuple[int, ...]
    parking: Tuple[int, ...]
    latency: float = 0.1
    rounds: int = 0
    order: OrderPolicy = OrderPolicy.FIXED
    work: SiteWork = SiteWork()
    times: WorkTimes = WorkTimes()
    begin: int = 0

    def robots(self, count: int) -> Dict[str, Robot]:
        """Returns `count` robots by name.

        If the fleet file has enough robots, the result is the first of them. Otherwise robots of
        its types are added in turn, and all robots begin on `starts`. Raises WrongSite if the graph
        cannot park that many robots.
        """
        if count <= len(self.fleet.robots):
            return {robot.name: robot for robot in self.fleet.robots[:count]}
        if count > len(self.starts):
            raise WrongSite(f'{count} robots are more than the {len(self.starts)} that the graph '
                            'can park without cutting off another robot: choose fewer robots, or '
                            'add parking vertices.')
        known = self.fleet.robots
        drivers = {robot.type.name: robot.driver for robot in known}
        kinds = [robot.type for robot in known] or list(self.fleet.types)
        step = len(self.starts) / count
        made: Dict[str, Robot] = {}
        for number in range(count):
            kind = kinds[number % len(kinds)]
            name = known[number].name if number < len(known) else f'{kind.name}_more_{number + 1}'
            made[name] = Robot(name, kind, self.starts[int(number * step)],
                               drivers.get(kind.name, ''))
        return made

    def settings_of(self, robots: Dict[str, Robot]) -> Dict[str, RobotSettings]:
        """Returns each robot's settings. An added robot has the settings of the first robot of its
        type.
        """
        by_type: Dict[str, RobotSettings] = {}
        for robot in self.fleet.robots:
            by_type.setdefault(robot.type.name, self.settings[robot.name])
        return {name: self.settings.get(name) or by_type.get(robot.type.name, RobotSettings())
                for name, robot in robots.items()}


def site_of(graph: Graph, fleet: Fleet, settings: Dict[str, RobotSettings], wanted: Wanted,
            latency: float = 0.1, rounds: int = 0) -> StudiedSite:
    """Returns the site; raises WrongSite or FileError if the demand cannot be served."""
    network = RoadNetwork(graph, (), fleet.dock_approach)
    for robot in fleet.robots:
        if robot.vertex not in graph.vertices:
            raise WrongSite(f'Robot {robot.name} begins on vertex {robot.vertex}, which the graph '
                            'does not have: choose another in the fleet file.')
    starts = tuple(place for place in _starts(network, fleet)
                   if place not in _at_stations(wanted.work))
    begin = {*starts, *(robot.vertex for robot in fleet.robots)}
    origins = lru_cache(maxsize=None)(partial(_origins, network, fleet))
    for (source, target), (file, line) in wanted.pairs.items():
        if source not in origins(target):
            raise FileError(file, f'no robot can drive from vertex {source} to vertex {target}: '
                                  'connect them in the graph, or remove this flow or mission', line)
    for place, (file, line) in wanted.places.items():
        if not origins(place) & (begin - {place} or begin):
            raise FileError(file, f'vertex {place} is not reachable: no robot can drive there from '
                                  'its start; connect it in the graph, or remove it here', line)
    for timetable in wanted.work.timetables.values():
        for place in _visited(timetable, wanted.work, graph):
            if not origins(place) & (begin - {place} or begin):
                raise WrongSite(f'Timetable {timetable.name} leads to vertex {place}, which no '
                                'robot can reach from its start: connect it in the graph.')
    return StudiedSite(graph, fleet, settings, wanted.demand, wanted.delays, starts,
                       tuple(sorted(parking_for_all(network, fleet))), latency, rounds,
                       work=wanted.work, times=wanted.times)


def _visited(timetable: Timetable, work: SiteWork, graph: Graph) -> Set[int]:
    """Returns the vertices to which the missions of a timetable may lead."""
    arguments = dict(timetable.arguments)
    words = (arguments[stop.at[len(PARAMETER):]] if stop.at.startswith(PARAMETER) else stop.at
             for stop in work.templates[timetable.template].stops)
    return {place for word in words for place in places_of(word, work.stations, graph)}


def _at_stations(work: SiteWork) -> Set[int]:
    """Returns the vertices of stations and queues, on which no robot is to begin."""
    return {place for one in work.stations.values() for place in (*one.places, *one.queue)}


def with_docks(fleet: Fleet, docks: FrozenSet[int]) -> Fleet:
    """Returns the fleet with more docks: each robot type that has docks may also use the new ones.
    """
    types = {kind.name: replace(kind, docks=kind.docks | docks) if kind.docks else kind
             for kind in fleet.types}
    return replace(fleet, types=tuple(types.values()), robots=tuple(
        replace(robot, type=types[robot.type.name]) for robot in fleet.robots))


def _origins(network: RoadNetwork, fleet: Fleet, target: int) -> FrozenSet[int]:
    """Returns the vertices from which a robot of at least one type can drive to the target."""
    is_dock = network.graph.vertices[target].dock
    found: Set[int] = set()
    for kind in fleet.types:
        if is_dock and not kind.may_dock(target):
            continue
        times = network.paths_to(kind, [network.index[target]])[0]
        found.update(id for id, place in network.index.items() if times[place] < inf)
    return frozenset(found)


def _starts(network: RoadNetwork, fleet: Fleet) -> Tuple[int, ...]:
    """Returns the largest set of vertices, without docks, on which robots of any type may stand for
    ever.
    """
    largest = max(fleet.types, key=lambda kind: kind.reach)
    kind = RobotType('any', largest.radius, largest.speed, largest.play, False)
    found = WellFormedSets(network, kind, fleet.clearance).largest()
    return tuple(sorted(network.vertex_ids[vertex] for vertex in found))
