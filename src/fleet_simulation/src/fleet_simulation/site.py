"""The site that is simulated: graph, robot types, demand; and the fleet of any size on it."""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache, partial
from math import inf
from typing import Dict, FrozenSet, Set, Tuple

from fleet_simulation.demand import Demand
from fleet_simulation.demand_file import Wanted
from fleet_simulation.driven_robot import Delays
from graph_fleet_manager.files.errors import FileError
from graph_fleet_manager.fleet import Fleet, Robot, RobotType
from graph_fleet_manager.planning.parking import Parking
from graph_fleet_manager.planning.road_network import RoadNetwork
from graph_fleet_manager.site.survey import parking_for_all
from graph_fleet_manager.supervision.settings import RobotSettings
from trajectory_graph import Graph


class WrongSite(Exception):
    """What cannot be simulated, and what to do: one sentence."""


class Order(Enum):
    """What becomes of the order of use while robots run late."""

    FIXED = 'fixed'
    SWITCHING = 'switching'    # corridors are reversed where that makes all sooner
    REPLANNING = 'replanning'  # all plans are made anew every few seconds


@dataclass(frozen=True)
class Site:
    """All that a run needs but the number of robots and the seed.

    starts  -- vertices on which robots of all types may stand for ever, evenly spread
    parking -- where the planner may park robots
    latency -- virtual s until the planner answers
    rounds  -- in which the planner makes a plan better
    order   -- of use, while robots run late
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
    order: Order = Order.FIXED

    def robots(self, count: int) -> Dict[str, Robot]:
        """The first robots of the fleet file; more of its types in turn, from parking places."""
        if count <= len(self.fleet.robots):
            return {robot.name: robot for robot in self.fleet.robots[:count]}
        if count > len(self.starts):
            raise WrongSite(f'{count} robots are more than the {len(self.starts)} that the graph '
                            'can park without cutting any robot off: choose fewer, or add parking.')
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
        """By robot; one that the fleet file does not name is as the others of its type."""
        by_type: Dict[str, RobotSettings] = {}
        for robot in self.fleet.robots:
            by_type.setdefault(robot.type.name, self.settings[robot.name])
        return {name: self.settings.get(name) or by_type.get(robot.type.name, RobotSettings())
                for name, robot in robots.items()}


def site_of(graph: Graph, fleet: Fleet, settings: Dict[str, RobotSettings], wanted: Wanted,
            latency: float = 0.1, rounds: int = 0) -> Site:
    """The site; raises WrongSite or FileError where the demand cannot be served."""
    network = RoadNetwork(graph, (), fleet.dock_approach)
    for robot in fleet.robots:
        if robot.vertex not in graph.vertices:
            raise WrongSite(f'Robot {robot.name} begins on vertex {robot.vertex}, which the graph '
                            'does not have: choose another.')
    starts = _starts(network, fleet)
    begin = {*starts, *(robot.vertex for robot in fleet.robots)}
    origins = lru_cache(maxsize=None)(partial(_origins, network, fleet))
    for (source, target), (file, line) in wanted.pairs.items():
        if source not in origins(target):
            raise FileError(file, f'no robot can drive from vertex {source} to vertex {target}: '
                                  'join them in the graph, or leave this out', line)
    for place, (file, line) in wanted.places.items():
        if not origins(place) & (begin - {place} or begin):
            raise FileError(file, f'vertex {place} is no destination: no robot can come there from '
                                  'a parking place', line)
    return Site(graph, fleet, settings, wanted.demand, wanted.delays, starts,
                tuple(sorted(parking_for_all(network, fleet))), latency, rounds)


def with_docks(fleet: Fleet, docks: FrozenSet[int]) -> Fleet:
    """The fleet, whose types that charge use these docks, too."""
    types = {kind.name: replace(kind, docks=kind.docks | docks) if kind.docks else kind
             for kind in fleet.types}
    return replace(fleet, types=tuple(types.values()), robots=tuple(
        replace(robot, type=types[robot.type.name]) for robot in fleet.robots))


def _origins(network: RoadNetwork, fleet: Fleet, target: int) -> FrozenSet[int]:
    """The vertices from which a robot of some type can drive to the target."""
    is_dock = network.graph.vertices[target].dock
    found: Set[int] = set()
    for kind in fleet.types:
        if is_dock and not kind.may_dock(target):
            continue
        times = network.paths_to(kind, [network.index[target]])[0]
        found.update(id for id, place in network.index.items() if times[place] < inf)
    return frozenset(found)


def _starts(network: RoadNetwork, fleet: Fleet) -> Tuple[int, ...]:
    """Docks aside, which are for charging."""
    largest = max(fleet.types, key=lambda kind: kind.reach)
    kind = RobotType('any', largest.radius, largest.speed, largest.play, False)
    found = Parking(network, kind, fleet.clearance).largest()
    return tuple(sorted(network.vertex_ids[vertex] for vertex in found))
