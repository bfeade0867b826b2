"""Assignment: which robot serves which mission, by the driving times to all of them together."""
from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import AbstractSet, Dict, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from fleet_core.interlocking.reports import GraphPosition
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.supervision.missions import Acceptance, Mission
from fleet_core.supervision.networks import Networks
from fleet_core.supervision.robots import ManagedRobot

_NEVER = 1e15   # s, in place of infinity: the matching needs finite costs
# s: more than all driving times together, so that an older mission is served first, however far it
# is
_LATER = 1e7


class Assigned(NamedTuple):
    """A mission and the robot that is to serve it."""

    mission: Mission
    robot: str


@dataclass(frozen=True)
class Assignment:
    """Which robot gets which mission now, and why some missions get no robot, in words.

    short -- by the serial of a mission, the robot that it waits for while that robot must charge
    """

    assigned: Tuple[Assigned, ...]
    waiting: Mapping[int, str]
    short: Mapping[int, str]


def assign(missions: Sequence[Mission], free: Mapping[str, ManagedRobot],
           robots: Mapping[str, ManagedRobot], acceptance: Acceptance,
           networks: Networks, now: float) -> Assignment:
    """Assigns missions to `free` robots: those of higher priority first, then the oldest.

    Among missions of one priority, the sum of the times to the first destinations is minimal. The
    range of a battery is compared with nominal times.
    """
    free = dict(free)
    works = frozenset(name for name, robot in robots.items() if robot.works)
    assigned: List[Assigned] = []
    waiting: Dict[int, str] = {}
    short: Dict[int, str] = {}
    order = sorted(missions, key=lambda m: (-m.request.priority, m.serial))
    while order:
        group = [m for m in order if m.request.priority == order[0].request.priority]
        order = order[len(group):]
        able: List[Mission] = []
        for mission in group:
            reason, empty = _why_nobody(mission, free, robots, works, acceptance,
                                        networks.nominal, now)
            if reason:
                waiting[mission.serial] = reason
                if empty:
                    short[mission.serial] = empty
            else:
                able.append(mission)
        for mission, name in _match(able, free, acceptance, networks):
            assigned.append(Assigned(mission, name))
            del free[name]
        taken = {mission.serial for mission, _ in assigned}
        waiting.update((mission.serial, _waits_for(acceptance.robots_for(mission.request)))
                       for mission in able if mission.serial not in taken)
    return Assignment(tuple(assigned), waiting, short)


def _match(missions: Sequence[Mission], free: Mapping[str, ManagedRobot], acceptance: Acceptance,
           networks: Networks) -> List[Tuple[Mission, str]]:
    names = list(free)
    found: List[Tuple[Mission, str]] = []
    pending = list(missions)
    if not names or not pending:
        return found
    pending = pending[:len(names)] if _all_alike(pending) else pending
    costs = np.full((len(pending), len(names)), _NEVER)
    for row, mission in enumerate(pending):
        for name in acceptance.robots_for(mission.request):
            if name in free and can_end(mission, free[name], networks.nominal):
                time = time_to(mission.request.destinations[0], free[name], networks.network)
                if time < inf:
                    costs[row, names.index(name)] = time + row * _LATER
    # The matching of scipy.sparse may take minutes if 200 robots cannot serve all missions.
    rows, columns = linear_sum_assignment(costs)
    for row, column in zip(rows.tolist(), columns.tolist()):
        if costs[row, column] < _NEVER:
            found.append((pending[row], names[column]))
    return found


def _all_alike(missions: Sequence[Mission]) -> bool:
    """May the same robots serve all missions, so that the oldest can be served first?"""
    return len({(m.request.robot_type, m.request.robot) for m in missions}) == 1


def _why_nobody(mission: Mission, free: Mapping[str, ManagedRobot],
                robots: Mapping[str, ManagedRobot], working: AbstractSet[str],
                acceptance: Acceptance, network: RoadNetwork, now: float) -> Tuple[str, str]:
    """Why no free robot can serve a mission, and the robot that could if it were charged.

    Each of the two is empty if it does not apply.
    """
    names = acceptance.robots_for(mission.request)
    works = [name for name in names if name in working]
    if not works:
        return _out_of_service([robots[name] for name in names]), ''
    able = [name for name in works if name in free]
    if not able:
        return _why_none_is_free(names, [robots[name] for name in works], now), ''
    reach = [name for name in able
             if time_over(mission.request.destinations, free[name], network) < inf]
    if not reach:
        return 'none of the free robots can reach all its destinations', ''
    if not any(can_end(mission, free[name], network) for name in reach):
        fullest = max(reach, key=lambda name: free[name].battery.range_left())
        return 'no free robot has enough charge for it', fullest
    return '', ''


def _out_of_service(robots: Sequence[ManagedRobot]) -> str:
    if len(robots) == 1:
        return f'{robots[0].name}: {robots[0].why or "it is stopped"}'
    return f'none of its robots is in service: {", ".join(robot.name for robot in robots)}'


def _why_none_is_free(names: Sequence[str], working: Sequence[ManagedRobot], now: float) -> str:
    if any(robot.is_charged for robot in working):
        return _waits_for(names)
    return _must_charge(working, now)


def _waits_for(names: Sequence[str]) -> str:
    return f'it waits for {names[0] if len(names) == 1 else "a robot"} to be free'


def _must_charge(robots: Sequence[ManagedRobot], now: float) -> str:
    whose = robots[0].name if len(robots) == 1 else 'each of its robots'
    mute = [robot.name for robot in robots if robot.battery.is_mute(robot.liveness, now)]
    if mute:
        return (f'{whose} must charge first, and there is no battery report from '
                f'{", ".join(mute)}')
    return f'{whose} must charge first'


def can_end(mission: Mission, robot: ManagedRobot, network: RoadNetwork) -> bool:
    """Has the robot enough charge for the whole mission?"""
    seconds = time_over(mission.left, robot, network)
    return seconds < inf and seconds * robot.type.speed <= robot.battery.range_left()


def time_to(vertex: int, robot: ManagedRobot, network: RoadNetwork) -> float:
    """Seconds from the robot's next resting place to a vertex, without traffic; infinite: no path.
    """
    record = robot.record
    times = network.paths_to(robot.type, (network.index[vertex],))[0]
    at = record.last_vertex
    if at is not None:
        return float(times[network.index[at]])
    place = record.position
    if place is None:
        return inf
    return min(seconds + float(times[network.index[end]])
               for end, seconds in _times_off(place, robot, network))


def time_over(vertices: Sequence[int], robot: ManagedRobot, network: RoadNetwork) -> float:
    """Seconds over all these vertices in order, without traffic."""
    seconds = time_to(vertices[0], robot, network)
    for one, other in zip(vertices, vertices[1:]):
        times = network.paths_to(robot.type, (network.index[other],))[0]
        seconds += float(times[network.index[one]])
    return seconds


def _times_off(place: GraphPosition, robot: ManagedRobot,
               network: RoadNetwork) -> List[Tuple[int, float]]:
    """The ends of the edge on which the robot stands, with the seconds to each end."""
    times = network.times(robot.type)
    forward, backward = network.drive(place.edge), network.drive(-place.edge)
    graph = network.graph
    return [(graph.end_vertex(place.edge).id, times[forward] * (1.0 - place.fraction)),
            (graph.end_vertex(-place.edge).id, times[backward] * place.fraction)]
