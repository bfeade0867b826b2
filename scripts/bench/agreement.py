#!/usr/bin/env python3
"""Does the fleet in virtual time do what the fleet in real time does?

The real one is the factory, as `scripts/run.sh fleet:=4 longest_edge:=1.5 demo:=true` starts it:
simulated LD-90s and AGVs, their ROS nodes, the fleet manager, random missions, at real speed. The
virtual one is `fleet_simulation` with the same graph, robots and missions, without delays of
chance. Told are missions an hour, and the share of the time with a mission in which robots stand.

`--minutes M` of real time (60), `--virtual N` virtual hours (20); `--real R` takes the real figures
from a file that `--keep FILE` of an earlier run wrote.
"""
from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import time
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any, Dict, List, NamedTuple, Sequence, Tuple

from factory import COUNT, WARM_UP, factory, running
from measuring.tables import print_table
from scipy.stats import t as students_t

from fleet_bringup.made_fleet import RELEASE_AHEAD, STOPPING, made_fleet
from fleet_simulation.batch import Job, Progress, run_all
from fleet_simulation.demand import Demand, Flow, Saturated
from fleet_simulation.demand_file import Wanted
from fleet_simulation.driven_robot import Delays, Standstill
from fleet_simulation.figures import Figures, Use
from fleet_simulation.site import Site, site_of
from graph_fleet_manager.nodes.random_missions import places_by_edge
from graph_fleet_manager.supervision.missions import Request
from graph_fleet_manager.supervision.settings import RobotSettings
from trajectory_graph import load_graph, split_edges

ROOT = Path(__file__).resolve().parents[2]
LONGEST_EDGE = 1.5    # m
MOST = 2              # destinations of a random mission
LOOK = 1.0            # s between two looks at the robots
MOVED, TURNED = 0.01, 0.01  # m and rad in a look that count as motion
NEVER = Standstill(0.0, 0.0)


class Hour(NamedTuple):
    """Missions that succeeded, an hour; share of the robots' time with a mission that they stood.
    """

    missions: float
    standing: float


@dataclass(frozen=True)
class RandomFlow(Flow):
    """Missions as `random_missions` draws them: over one or more of the places, each once."""

    def draw(self, random: Random, id: int, stamp: float) -> Request:
        """One mission."""
        count = random.randint(1, MOST)
        return Request(id, tuple(random.sample(self.targets, count)), stamp=stamp)


# --- real time ------------------------------------------------------------------------------------

def watch(master: str, count: int, seen: Any) -> None:
    """Puts `ready` when so many robots take missions, then each mission's success, and at each look
    how many robots have a mission, and how many of these stand."""
    import rosgraph
    import rospy

    from itrci_nav_msgs.msg import FleetPoses, FleetRobot, FleetState, MissionStatus
    os.environ['ROS_MASTER_URI'] = master
    while not rosgraph.Master('/bench').is_online():
        time.sleep(0.01)
    rospy.init_node('bench', anonymous=True, disable_signals=True)
    robots: Dict[str, FleetRobot] = {}
    poses: Dict[str, Tuple[float, float, float]] = {}
    before: Dict[str, Tuple[float, float, float]] = {}
    is_ready = False

    def on_state(state: FleetState) -> None:
        nonlocal is_ready
        robots.update((one.name, one) for one in state.robots)
        if not is_ready and count == sum(
                one.state in (FleetRobot.IDLE, FleetRobot.BUSY) for one in state.robots):
            is_ready = True
            seen.put(('ready', time.monotonic()))

    def on_status(status: MissionStatus) -> None:
        if status.state == MissionStatus.SUCCEEDED:
            seen.put(('mission', time.monotonic()))

    rospy.Subscriber('/fleet_state', FleetState, on_state, queue_size=10)
    rospy.Subscriber('/mission_status', MissionStatus, on_status, queue_size=100)
    rospy.Subscriber('/fleet_poses', FleetPoses, lambda message: poses.update(
        (one.robot, (one.x, one.y, one.theta)) for one in message.poses), queue_size=1)
    next_look = time.monotonic()
    while not rospy.is_shutdown():
        next_look += LOOK
        time.sleep(max(next_look - time.monotonic(), 0.0))
        served = [name for name, robot in robots.items() if robot.has_mission and name in before]
        stand = sum(not has_moved(before[name], poses[name]) for name in served)
        before = dict(poses)
        if is_ready:
            seen.put(('look', time.monotonic(), len(served), stand))


def has_moved(before: Tuple[float, float, float], now: Tuple[float, float, float]) -> bool:
    """Between two looks."""
    return (math.dist(before[:2], now[:2]) > MOVED
            or abs(math.remainder(now[2] - before[2], math.tau)) > TURNED)


def real(minutes: float) -> Hour:
    """What the factory does, after the robots have spread."""
    missions, served, stood = 0, 0, 0
    with running(factory('rviz:=false', 'demo:=true'), watch, 2 * COUNT) as run:
        begin = time.monotonic() + WARM_UP
        end = begin + 60.0 * minutes
        while True:
            what, at, *more = run.seen.get(timeout=30.0)
            if at >= end:
                break
            if at >= begin and what == 'mission':
                missions += 1
            elif at >= begin and what == 'look':
                served, stood = served + more[0], stood + more[1]
    return Hour(60.0 * missions / minutes, stood / max(served, 1))


# --- virtual time ---------------------------------------------------------------------------------

def virtual_site() -> Site:
    """The factory's graph, fleet and missions."""
    whole = load_graph(ROOT / 'maps/lab_graph.yaml')
    graph = split_edges(whole, LONGEST_EDGE)
    fleet = made_fleet(COUNT, whole)
    settings = {robot.name: RobotSettings(release_ahead=RELEASE_AHEAD[robot.type.name],
                                          stopping=STOPPING[robot.type.name])
                for robot in fleet.robots}
    places = tuple(sorted({place for found in places_by_edge(graph).values() for place in found}))
    flow = RandomFlow('random', (), places, Saturated())
    return site_of(graph, fleet, settings,
                   Wanted(Demand((flow,)), Delays(1.0, NEVER, NEVER), {}, {}))


def virtual(hours: int) -> List[Hour]:
    """So many hours, each from a seed of its own."""
    jobs = [Job(0, 2 * COUNT, seed, 1.0) for seed in range(1, hours + 1)]
    done, _ = run_all([virtual_site()], jobs, os.cpu_count() or 1, Progress('virtual hours'))
    return [hour_of(figures) for _, figures in done]


def hour_of(figures: Figures) -> Hour:
    """The same figures of a virtual run."""
    assert not figures.trouble, f'seed {figures.seed}: {figures.trouble}'
    stood, drove = figures.use[Use.WAITING], figures.use[Use.LOADED]
    return Hour(figures.per_hour, stood / (stood + drove))


# --- both -----------------------------------------------------------------------------------------

def print_agreement(real_hour: Hour, hours: Sequence[Hour]) -> None:
    """The real figures beside mean and range of the virtual ones."""
    rows = []
    for name, of, show in (('missions an hour', lambda hour: hour.missions, '{:.0f}'),
                           ('standing, with a mission', lambda hour: hour.standing, '{:.1%}')):
        values = [of(hour) for hour in hours]
        mean, half = statistics.mean(values), half_width(values)
        measured = of(real_hour)
        rows.append((name, show.format(measured), show.format(mean),
                     f'{show.format(mean - half)} to {show.format(mean + half)}',
                     'yes' if abs(measured - mean) <= half else 'NO',
                     f'{100.0 * (measured / mean - 1.0):+.1f} %'))
    print_table(rows, ('figure', 'real', f'mean of {len(hours)} virtual hours',
                       'range of 95 % of single virtual hours', 'real within', 'real to mean'))


def half_width(values: Sequence[float]) -> float:
    """Of the range in which one more hour lies with 95 %."""
    count = len(values)
    return float(students_t.ppf(0.975, count - 1)) * statistics.stdev(values) * math.sqrt(
        1.0 + 1.0 / count)


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--minutes', type=float, default=60.0, help='of real time')
    parser.add_argument('--virtual', type=int, default=20, metavar='N', help='hours')
    parser.add_argument('--real', type=Path, metavar='FILE', help='an earlier run kept it')
    parser.add_argument('--keep', type=Path, metavar='FILE', help='for the real figures')
    options = parser.parse_args()
    measured = (Hour(*json.loads(options.real.read_text())) if options.real
                else real(options.minutes))
    if options.keep:
        options.keep.write_text(json.dumps(measured))
    print_agreement(measured, virtual(options.virtual))


if __name__ == '__main__':
    main()
