#!/usr/bin/env python3
"""Compares the fleet in virtual time with the fleet in real time.

The real fleet is the factory that `scripts/run.sh fleet:=4 longest_edge:=1.5 demo:=true` starts, at
real speed: simulated LD-90s and AGVs, their ROS nodes, the fleet manager, random missions. The
virtual fleet is `fleet_simulation` with the same graph, robots and missions, without random delays.
Both are observed once a second, and the same function evaluates them.

`--minutes M` sets the minutes of real time (60), `--virtual N` the number of virtual runs of the
same length (20). `--keep FILE` stores the observations of the real fleet. `--real FILE` reads
stored observations instead of starting the real fleet.
"""
from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import statistics
import time
from collections import Counter
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from random import Random
from typing import Any, Callable, Dict, Iterable, Iterator, List, NamedTuple, Sequence, Tuple, Union

from factory import COUNT, factory, running
from measuring.tables import print_table
from scipy.stats import t as students_t

from fleet_bringup.made_fleet import RELEASE_AHEAD, made_fleet
from fleet_core.supervision.missions import MissionState, Request, Status
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.demand import Demand, Flow, Saturated
from fleet_simulation.demand_file import Wanted
from fleet_simulation.driven_robot import Delays, RandomStops
from fleet_simulation.simulation import Run
from fleet_simulation.site import StudiedSite, site_of
from graph_fleet_manager.nodes.random_missions import places_by_edge
from trajectory_graph import load_graph, split_edges

ROOT = Path(__file__).resolve().parents[2]
LONGEST_EDGE = 1.5    # m
MOST = 2              # largest number of destinations of a random mission
LOOK = 1.0            # s between two observations of the robots
WARM_UP = 120.0       # s for the robots to spread over the graph
MOVED, TURNED = 0.01, 0.01  # m and rad; a larger change within LOOK is motion
NEVER = RandomStops(0.0, 0.0)
KINDS = {'ld90': 'LD-90s', 'agv': 'AGVs'}


class Seen(NamedTuple):
    """One robot in one observation: x, y in m, heading in rad, and whether it has a mission."""

    name: str
    x: float
    y: float
    heading: float
    has_mission: bool

    @property
    def kind(self) -> str:
        """A key of KINDS."""
        return self.name.partition('_')[0]

    def has_moved(self, before: Seen) -> bool:
        """Returns whether the robot has driven or turned since the observation `before`."""
        return (math.dist((before.x, before.y), (self.x, self.y)) > MOVED
                or abs(math.remainder(self.heading - before.heading, math.tau)) > TURNED)


class Look(NamedTuple):
    """All robots at one time. The time is in s, and begins when all robots are ready."""

    time: float
    robots: Tuple[Seen, ...]


class Success(NamedTuple):
    """The success of a mission: its time (s), and the name of the robot."""

    time: float
    name: str


Observation = Union[Look, Success]


@dataclass(frozen=True)
class RandomFlow(Flow):
    """Missions like those of `random_missions`: to one or more different places."""

    def draw(self, random: Random, id: int, stamp: float) -> Request:
        """Returns one mission."""
        count = random.randint(1, MOST)
        return Request(id, tuple(random.sample(self.targets, count)), stamp=stamp)


# --- figures of the observations ------------------------------------------------------------------

def figures_of(observations: Iterable[Observation], seconds: float) -> Dict[str, float]:
    """Returns figures by their names, from the observations of `seconds` s after the warm-up."""
    missions: Counter[str] = Counter()
    served: Counter[str] = Counter()   # how often a robot was observed with a mission
    moving: Counter[str] = Counter()   # how often such a robot had moved since the last look
    metres: Dict[str, float] = dict.fromkeys(KINDS, 0.0)
    before: Dict[str, Seen] = {}
    for one in observations:
        if not WARM_UP <= one.time < WARM_UP + seconds:
            continue
        if isinstance(one, Success):
            missions[one.name.partition('_')[0]] += 1
            continue
        for robot in one.robots:
            last = before.get(robot.name)
            before[robot.name] = robot
            if last is None:
                continue
            metres[robot.kind] += math.dist((last.x, last.y), (robot.x, robot.y))
            served[robot.kind] += robot.has_mission
            moving[robot.kind] += robot.has_mission and robot.has_moved(last)
    all_served = max(sum(served.values()), 1)
    figures = {'missions an hour': 3600.0 * sum(missions.values()) / seconds,
               'standing, with a mission, %': 100.0 - 100.0 * sum(moving.values()) / all_served}
    for kind, name in KINDS.items():
        figures[f'{name}: missions an hour'] = 3600.0 * missions[kind] / seconds
        figures[f'{name}: m driven for a mission'] = metres[kind] / max(missions[kind], 1)
        figures[f'{name}: m/s while moving'] = metres[kind] / max(moving[kind] * LOOK, 1.0)
    return figures


# --- real time ------------------------------------------------------------------------------------

def watch(master: str, count: int, seen: Any) -> None:
    """Puts `ready` into `seen` when `count` robots take missions, then puts each observation."""
    import rosgraph
    import rospy

    from itrci_nav_msgs.msg import FleetPoses, FleetRobot, FleetState, MissionStatus
    os.environ['ROS_MASTER_URI'] = master
    while not rosgraph.Master('/bench').is_online():
        time.sleep(0.01)
    rospy.init_node('bench', anonymous=True, disable_signals=True)
    served: Dict[str, bool] = {}
    poses: Dict[str, Tuple[float, float, float]] = {}
    begun = math.inf

    def on_state(state: FleetState) -> None:
        nonlocal begun
        served.update((one.name, one.has_mission) for one in state.robots)
        if begun == math.inf and count == sum(
                one.state in (FleetRobot.IDLE, FleetRobot.BUSY) for one in state.robots):
            begun = time.monotonic()
            seen.put(('ready', begun))

    def on_status(status: MissionStatus) -> None:
        if status.state == MissionStatus.SUCCEEDED and begun < math.inf:
            seen.put(Success(time.monotonic() - begun, status.robot))

    rospy.Subscriber('/fleet_state', FleetState, on_state, queue_size=10)
    rospy.Subscriber('/mission_status', MissionStatus, on_status, queue_size=100)
    rospy.Subscriber('/fleet_poses', FleetPoses, lambda message: poses.update(
        (one.robot, (one.x, one.y, one.theta)) for one in message.poses), queue_size=1)
    next_look = time.monotonic()
    while not rospy.is_shutdown():
        next_look += LOOK
        time.sleep(max(next_look - time.monotonic(), 0.0))
        now = time.monotonic()
        if now > begun:
            seen.put(Look(now - begun, tuple(Seen(name, *pose, served.get(name, False))
                                             for name, pose in poses.items())))


def real(seconds: float) -> List[Observation]:
    """Returns the observations of the factory."""
    observed: List[Observation] = []
    with running(factory('rviz:=false', 'demo:=true'), watch, 2 * COUNT) as run:
        while not observed or observed[-1].time < WARM_UP + seconds:
            observed.append(run.seen.get(timeout=30.0))
    return observed


def kept(file: Path) -> Iterator[Observation]:
    """Yields the observations in a file of `--keep`."""
    with file.open() as lines:
        for moment, what in map(json.loads, lines):
            yield (Success(moment, what) if isinstance(what, str)
                   else Look(moment, tuple(Seen(*one) for one in what)))


# --- virtual time ---------------------------------------------------------------------------------

@lru_cache(maxsize=1)
def virtual_site() -> StudiedSite:
    """Returns the factory's graph, fleet and missions."""
    whole = load_graph(ROOT / 'maps/lab_graph.yaml')
    graph = split_edges(whole, LONGEST_EDGE)
    fleet = made_fleet(COUNT, whole)
    settings = {robot.name: RobotSettings(release_ahead=RELEASE_AHEAD[robot.type.name])
                for robot in fleet.robots}
    places = tuple(sorted({place for found in places_by_edge(graph).values() for place in found}))
    flow = RandomFlow('random', (), places, Saturated())
    return site_of(graph, fleet, settings,
                   Wanted(Demand((flow,)), Delays(1.0, NEVER, NEVER), {}, {}))


class ObservedRun(Run):
    """A virtual run that is observed in the same way as the real fleet."""

    def __init__(self, site: StudiedSite, seed: int) -> None:
        super().__init__(site, 2 * COUNT, seed)
        self.observed: List[Observation] = []
        self._looked = 0.0

    def publishes(self, status: Status) -> None:
        """Notes each mission that has succeeded."""
        if status.state is MissionState.SUCCEEDED:
            self.observed.append(Success(self.world.now, status.robot))
        super().publishes(status)

    def stepped(self) -> None:
        """Observes the fleet after a time step if LOOK has passed since the last observation."""
        super().stepped()
        if self.world.now >= self._looked + LOOK - 1e-6:
            self._looked = self.world.now
            book = self.world.supervisor.book
            self.observed.append(Look(self.world.now, tuple(
                Seen(name, *robot.vehicle.pose, book.of_robot(name) is not None)
                for name, robot in self.world.agvs.items())))


def virtual(seconds: float, seed: int) -> Dict[str, float]:
    """Returns the figures of one virtual run."""
    run = ObservedRun(virtual_site(), seed)
    trouble = run.run((WARM_UP + seconds) / 3600.0).trouble
    assert not trouble, f'seed {seed}: {trouble}'
    return figures_of(run.observed, seconds)


# --- both -----------------------------------------------------------------------------------------

def print_agreement(real_hour: Dict[str, float], hours: Sequence[Dict[str, float]]) -> None:
    """Prints each real figure beside the mean and the range of the virtual figures."""
    rows = []
    for name, measured in real_hour.items():
        show: Callable[[float], str] = ('{:.0f}' if measured >= 100.0 else '{:.1f}').format
        if name.endswith('moving'):
            show = '{:.3f}'.format
        values = [hour[name] for hour in hours]
        mean, half = statistics.mean(values), half_width(values)
        rows.append((name, show(measured), show(mean),
                     f'{show(mean - half)} to {show(mean + half)}',
                     'yes' if abs(measured - mean) <= half else '**no**',
                     f'{100.0 * (measured / mean - 1.0):+.1f} %'))
    print_table(rows, ('figure', 'real', f'mean of {len(hours)} virtual runs',
                       'range of 95 % of single virtual runs', 'real within', 'real to mean'))


def half_width(values: Sequence[float]) -> float:
    """Returns half the width of the range that contains the figure of a further run with a
    probability of 95 %.
    """
    count = len(values)
    return float(students_t.ppf(0.975, count - 1)) * statistics.stdev(values) * math.sqrt(
        1.0 + 1.0 / count)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--minutes', type=float, default=60.0, help='of real time')
    parser.add_argument('--virtual', type=int, default=20, metavar='N', help='runs')
    parser.add_argument('--real', type=Path, metavar='FILE', help='an earlier run kept it')
    parser.add_argument('--keep', type=Path, metavar='FILE', help='for what is observed')
    options = parser.parse_args()
    seconds = 60.0 * options.minutes
    observed = list(kept(options.real)) if options.real else real(seconds)
    if options.keep:
        with options.keep.open('w') as lines:
            lines.writelines(json.dumps(one) + '\n' for one in observed)
    with multiprocessing.Pool(os.cpu_count()) as pool:
        hours = pool.map(partial(virtual, seconds), range(1, options.virtual + 1), 1)
    print_agreement(figures_of(observed, seconds), hours)


if __name__ == '__main__':
    main()
