"""Assignment: decides which robot serves which mission, so that the robots together drive little.
"""
from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Dict, Iterable, List, Mapping, NamedTuple, Sequence, Tuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from fleet_core.interlocking.reports import GraphPosition
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.supervision.hindrances import Hindrance
from fleet_core.supervision.missions import Acceptance, Mission
from fleet_core.supervision.networks import Networks
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.station_room import NO_STATIONS, StationRoom

_NEVER = 1e15   # s, in place of infinity: the matching needs finite costs
# s: more than all driving times together, so that an older mission is served first even if it is
# far away
_LATER = 1e7


class Assigned(NamedTuple):
    """A mission and the robot that is to serve it."""

    mission: Mission
    robot: str


@dataclass(frozen=True)
class Assignment:
    """Which robot gets which mission now, and why some missions get no robot, in words.

    short -- by the serial of a mission, the robot that could serve it after charging
    """

    assigned: Tuple[Assigned, ...]
    waiting: Mapping[int, str]
    short: Mapping[int, str]


def assign(missions: Sequence[Mission], own: Mapping[str, Hindrance],
           robots: Mapping[str, ManagedRobot], acceptance: Acceptance,
           networks: Networks, now: float, room: StationRoom = NO_STATIONS) -> Assignment:
    """Assigns missions to robots: by descending priority, and by age if priorities are equal.

    Among missions of one priority, the sum of the times to the first destinations is minimal. The
    charge that a mission needs follows from nominal driving times. A station gets no more robots
    than the station and its queue have room for.

    own  -- by robot, what hinders it from serving any mission
    room -- the free places at stations and chargers before any of these missions gets a robot
    """
    own, room = dict(own), room.copy()
    assigned: List[Assigned] = []
    waiting: Dict[int, str] = {}
    short: Dict[int, str] = {}
    order = sorted(missions, key=lambda m: (-m.request.priority, m.serial))
    while order:
        group = [m for m in order if m.request.priority == order[0].request.priority]
        order = order[len(group):]
        able: List[Tuple[Mission, Sequence[str]]] = []
        left = room.copy()
        # By the robots that may serve a mission: what it waits for if none of them is free.
        busy: Dict[Tuple[str, ...], str] = {}
        for mission in group:
            names = acceptance.robots_for(mission.request)
            if names in busy:
                waiting[mission.serial] = busy[names]
                continue
            found = hindrances(mission, own, robots, acceptance, networks.nominal, left)
            reason, empty = why_nobody(mission, found, robots, now, left)
            waiting[mission.serial] = reason
            if empty:
                short[mission.serial] = empty
            if all(own[name] for name in names):
                busy[names] = reason
            able_ones = [name for name, one in found.items() if one is Hindrance.NONE]
            if able_ones:
                able.append((mission, able_ones))
                left.send(mission)
        for mission, name in _match(able, robots, networks):
            assigned.append(Assigned(mission, name))
            own[name] = Hindrance.BUSY
            room.send(mission)
            del waiting[mission.serial]
    return Assignment(tuple(assigned), waiting, short)


def hindrances(mission: Mission, own: Mapping[str, Hindrance], robots: Mapping[str, ManagedRobot],
               acceptance: Acceptance, network: RoadNetwork,
               room: StationRoom) -> Dict[str, Hindrance]:
    """Returns, for each robot that may serve a mission, why it cannot serve the mission now.

    own -- by robot, what hinders it from serving any mission
    """
    is_full, leaving = room.full(mission) is not None, room.leaving(mission)
    return {name: own[name] or _on_the_way(mission, robots[name], network) or (
                Hindrance.FULL if is_full or name in leaving else Hindrance.NONE)
            for name in acceptance.robots_for(mission.request)}


def own_hindrance(robot: ManagedRobot, is_busy: bool, is_laden: bool) -> Hindrance:
    """Returns what hinders a robot from serving any mission now."""
    some = ((robot.outage is not None, Hindrance.OUTAGE), (robot.is_halted, Hindrance.HALTED),
            (is_busy, Hindrance.BUSY), (is_laden, Hindrance.LADEN),
            (not robot.is_charged, Hindrance.MUST_CHARGE),
            (robot.record.position is None and not robot.record.held, Hindrance.NO_PLACE))
    return next((hindrance for is_so, hindrance in some if is_so), Hindrance.NONE)


def _on_the_way(mission: Mission, robot: ManagedRobot, network: RoadNetwork) -> Hindrance:
    """Returns why a free robot cannot drive to all destinations of a mission."""
    left = mission.left
    seconds = time_to(left[0], robot, network) + network.seconds_over(robot.type, left)
    if seconds == inf:
        return Hindrance.NO_WAY
    lasts = seconds * robot.type.speed <= robot.battery.range_left()
    return Hindrance.NONE if lasts else Hindrance.BATTERY


def _match(missions: Sequence[Tuple[Mission, Sequence[str]]], robots: Mapping[str, ManagedRobot],
           networks: Networks) -> List[Tuple[Mission, str]]:
    """Returns pairs of a mission and the robot that is to serve it.

    missions -- each with the names of the robots that can serve it
    """
    useful = {name for _, able in missions for name in able}
    names = [name for name in robots if name in useful]
    numbers = {name: number for number, name in enumerate(names)}
    found: List[Tuple[Mission, str]] = []
    if not names:
        return found
    pending = missions[:len(names)] if _all_alike([one for one, _ in missions]) else missions
    costs = np.full((len(pending), len(names)), _NEVER)
    for row, (mission, able) in enumerate(pending):
        for name in able:
            time = time_to(mission.request.destinations[0], robots[name], networks.network)
            if time < inf:
                costs[row, numbers[name]] = time + row * _LATER
    # The matching of scipy.sparse may take minutes if 200 robots cannot serve all missions.
    rows, columns = linear_sum_assignment(costs)
    for row, column in zip(rows.tolist(), columns.tolist()):
        if costs[row, column] < _NEVER:
            found.append((pending[row][0], names[column]))
    return found


def _all_alike(missions: Sequence[Mission]) -> bool:
    """Returns whether the same robots may serve all missions. Then only the oldest are matched."""
    return len({(m.request.robot_type, m.request.robot) for m in missions}) == 1


def why_nobody(mission: Mission, found: Mapping[str, Hindrance],
               robots: Mapping[str, ManagedRobot], now: float,
               room: StationRoom) -> Tuple[str, str]:
    """Returns what a mission waits for, according to the hindrances of its robots.

    The second value is the robot that could serve the mission after charging; empty: none.
    """
    names = list(found)
    serving = [robots[name] for name in names if not found[name].is_outage]
    if not serving:
        return _out_of_service([robots[name] for name in names]), ''
    free = [robot for robot in serving if found[robot.name].is_free]
    if not free and _must_all_charge(serving):
        return _must_charge(serving, now), ''
    full = room.full(mission)
    if full is not None and Hindrance.FULL in found.values():
        return room.why_full(full), ''
    if free and Hindrance.NONE not in found.values():
        return _unable([robot for robot in free if found[robot.name] is Hindrance.BATTERY])
    return _until_free(names), ''


def _must_all_charge(robots: Iterable[ManagedRobot]) -> bool:
    return not any(robot.is_charged for robot in robots)


def _until_free(names: Sequence[str]) -> str:
    return f'it waits for {names[0] if len(names) == 1 else "a robot"} to be free'


def _out_of_service(robots: Sequence[ManagedRobot]) -> str:
    if len(robots) == 1:
        return f'{robots[0].name}: {robots[0].why or "it is stopped"}'
    return f'none of its robots is in service: {", ".join(robot.name for robot in robots)}'


def _unable(short: Sequence[ManagedRobot]) -> Tuple[str, str]:
    """Returns why no free robot can serve a mission.

    The second value is the robot in `short` with the longest range. `short` has the free robots
    whose charge is too low.
    """
    if not short:
        return 'none of the free robots can reach all its destinations', ''
    fullest = max(short, key=lambda robot: robot.battery.range_left())
    return 'no free robot has enough charge for it', fullest.name


def _must_charge(robots: Sequence[ManagedRobot], now: float) -> str:
    whose = robots[0].name if len(robots) == 1 else 'each of its robots'
    mute = [robot.name for robot in robots if robot.battery.is_mute(robot.liveness, now)]
    if mute:
        return (f'{whose} must charge first, and there is no battery report from '
                f'{", ".join(mute)}')
    return f'{whose} must charge first'


def time_to(vertex: int, robot: ManagedRobot, network: RoadNetwork) -> float:
    """Returns the seconds from the robot's next resting place to a vertex, without traffic.

    Infinite: there is no path, or the vertex is not in the graph.
    """
    record = robot.record
    if vertex not in network.index:
        return inf
    times = network.paths_to(robot.type, (network.index[vertex],))[0]
    at = record.last_vertex
    if at is not None:
        return float(times[network.index[at]])
    place = record.position
    if place is None:
        return inf
    return min(seconds + float(times[network.index[end]])
               for end, seconds in _times_off(place, robot, network))


def _times_off(place: GraphPosition, robot: ManagedRobot,
               network: RoadNetwork) -> List[Tuple[int, float]]:
    """Returns the ends of the edge on which the robot stands, with the seconds to each end."""
    times = network.times(robot.type)
    forward, backward = network.drive(place.edge), network.drive(-place.edge)
    graph = network.graph
    return [(graph.end_vertex(place.edge).id, times[forward] * (1.0 - place.fraction)),
            (graph.end_vertex(-place.edge).id, times[backward] * place.fraction)]
