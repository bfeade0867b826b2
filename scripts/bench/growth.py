#!/usr/bin/env python3
"""Measures how the cost of the main tasks grows with their size, and prints the exponents.

Each row has one task at three sizes. The cost is proportional to the size to the power of the
exponent: with 0 the cost does not grow, with 1 it is proportional, with 2 it grows with the square.
Each cost is the lowest CPU time of several runs. All rows together take about four minutes.
"""
from __future__ import annotations

import io
import os
import tempfile
import time
from random import Random
from typing import Callable, Iterator, List, NamedTuple, Sequence, cast

import numpy as np
import page
import rospy
from fleet_bench.operation import AGV, PARKING, ROOT, STATIONS, at_work
from load_bench.site import grid, starts
from measuring.ros_master import own_ros_master
from measuring.sections import print_sections
from measuring.tables import Row

from fleet_core.fleet import DOCK_APPROACH, Fleet
from fleet_core.planning.plan_requests import PlanRequest
from fleet_core.planning.plan_service import PlanService
from fleet_core.planning.tasks import Task
from itrci_nav_msgs.msg import EdgeState, ExecutionRouteStates
from omron_map import MapDocument
from ports import free_port
from route_protocol.messages import fill_report
from route_protocol.values import Motion, RouteOrder, SymbolicPose
from route_protocol.vehicle import Vehicle
from trajectory_graph import Graph, load_graph

RUNS = 5
LABORATORY = load_graph(ROOT / 'maps/lab_graph.yaml')
FLEET = Fleet((AGV,), (), 0.1, DOCK_APPROACH)


class Cost(NamedTuple):
    """The CPU time of one task at one size, in ms."""

    size: int
    milliseconds: float


def exponent(costs: Sequence[Cost]) -> float:
    """Returns the slope of log(cost) over log(size)."""
    sizes, times = np.log([(cost.size, cost.milliseconds) for cost in costs]).T
    return float(np.polyfit(sizes, times, 1)[0])


def row(task: str, costs: Sequence[Cost], aim: str = 'at most 1.2') -> Row:
    """Returns the row of the table for one task."""
    sizes = ', '.join(f'{cost.size:,}' for cost in costs)
    times = ', '.join(f'{cost.milliseconds:,.3g}' for cost in costs)
    return Row(f'{task}: {sizes}', f'{times} ms', f'exponent {exponent(costs):.2f}', aim)


def lowest(run: Callable[[], object], runs: int = RUNS) -> float:
    """Returns the lowest CPU time of several runs, in ms."""
    found = []
    for _ in range(runs):
        begun = time.process_time()
        run()
        found.append(time.process_time() - begun)
    return 1e3 * min(found)


# -- fleet -----------------------------------------------------------------------------------------

def missions() -> Iterator[Row]:
    """Measures a fleet at work in virtual time while further missions wait for a robot."""
    yield row('missions that wait, 8 robots at work in the laboratory: 300 s of virtual time', [
        Cost(waiting, at_work_costs(8, waiting)) for waiting in (500, 1500, 4500)], 'at most 0.5')


def robots() -> Iterator[Row]:
    """Measures a fleet at work in virtual time."""
    yield row('robots at work in the laboratory: 300 s of virtual time', [
        Cost(count, at_work_costs(count, 0)) for count in (2, 4, 8)], 'at most 1.5')


def at_work_costs(count: int, waiting: int) -> float:
    """Returns the CPU time (ms) of a fleet that works for 300 virtual s."""
    return lowest(lambda: at_work(LABORATORY, AGV, PARKING[:count], STATIONS, 0, 300.0, 20,
                                  waiting), 2)


def vertices() -> Iterator[Row]:
    """Measures the preparation of the planner, and a plan for 20 robots, on growing grids."""
    sides = (20, 40, 80)
    yield row('vertices of a grid: preparing the planner', [
        Cost(side * side, preparation(grid(side))) for side in sides])
    yield row('vertices of a grid: a plan for 20 robots', [
        Cost(side * side, plan_of_20(grid(side))) for side in sides])


def preparation(graph: Graph) -> float:
    """Returns the CPU time (ms) until the planner is ready."""
    return lowest(lambda: PlanService(graph, FLEET).prepare(), 2)


def plan_of_20(graph: Graph) -> float:
    """Returns the CPU time (ms) of a plan for 20 robots that drive in one corner of a grid."""
    service = PlanService(graph, FLEET)
    service.prepare()
    corner = grid(20)
    random, ids = Random(0), list(corner.vertices)
    request = PlanRequest(tuple(
        Task(name, AGV, vertex, destinations=(random.choice(ids),))
        for name, vertex in starts(corner, 20).items()),
        parking=service.parking_by_name(), time_limit=30.0, improvement=0.0)
    return lowest(lambda: service.answer(request), 3)


# -- one robot -------------------------------------------------------------------------------------

def points() -> Iterator[Row]:
    """Measures the reading and checking of maps."""
    yield row('points of a map: read and checked', [
        Cost(count, map_reading(count)) for count in (10_000, 100_000, 1_000_000)])


def map_reading(count: int) -> float:
    """Returns the CPU time (ms) in which a map with this number of points is read."""
    draw = np.random.default_rng(1)
    some = np.unique(draw.integers(-20_000, 20_000, (count + count // 50, 2)) * 20,
                     axis=0)[:count]
    (left, low), (right, high) = some.min(axis=0), some.max(axis=0)
    data = (f'2D-Map\nMinPos: {left} {low}\nMaxPos: {right} {high}\nNumPoints: {count}\n'
            'PointsAreSorted: true\nResolution: 20\nDATA\n'
            + ''.join(f'{x} {y}\n' for x, y in cast(List[List[int]], some.tolist()))).encode()
    return lowest(lambda: MapDocument.from_bytes(data).warnings)


def edges() -> Iterator[Row]:
    """Measures a vehicle that drives a route, and reports each completed edge as a ROS message."""
    yield row('edges of a route: one report, as a message', [
        Cost(count, reporting(count)) for count in (10, 100, 1000)], 'at most 1')


def reporting(count: int) -> float:
    """Returns the CPU time (ms) of one report on a route with this number of edges."""
    vehicle = Vehicle(lambda: 1, lambda: 0)
    vehicle.take_order(RouteOrder(1, tuple(range(1, count + 1)), order=1, known_epoch=1,
                                  master='bench'), 0)

    def report() -> None:
        vehicle.complete(vehicle.state.done + 1)
        message = fill_report(ExecutionRouteStates(), vehicle.report(
            1, SymbolicPose(1, 50.0), None, Motion.ON_ROUTE), EdgeState)
        message.serialize(io.BytesIO())

    return lowest(report, 10)


# -- page ------------------------------------------------------------------------------------------

def clients() -> Iterator[Row]:
    """Measures the CPU use of the page's node and door, with clients that read all data."""
    os.environ.setdefault('ROS_IP', '127.0.0.1')
    with tempfile.TemporaryDirectory() as folder, own_ros_master():
        rospy.init_node('bench', anonymous=True, disable_signals=True)
        fleet, port = page.Fleet(), free_port()
        costs, readers = [], 0
        with page.node(port, folder) as program:
            for count in (2, 8, 32):
                for _ in range(count - readers):
                    page.Reader(port).start()
                readers = count
                time.sleep(2.0)
                costs.append(Cost(count, 10.0 * page.cost(program, 10.0)))
        assert fleet.graph.vertices
    yield row(f'clients of the page, {page.ROBOTS} robots at 5 Hz: one second', costs, 'at most 1')


SECTIONS = {'missions': missions, 'robots': robots, 'vertices': vertices, 'points': points,
            'edges': edges, 'clients': clients}

if __name__ == '__main__':
    print_sections(SECTIONS, __doc__)
