"""Measures memory and CPU of route_visualisation with long routes and forged reports.

The floor is the same node with reports of an ordinary route at the same rate.
"""
from __future__ import annotations

import signal
import statistics
import subprocess
import time
from pathlib import Path
from typing import Callable, Iterator, NamedTuple

import rospy
from measuring.processes import cpu_seconds, resident
from measuring.ros_master import own_ros_master
from measuring.tables import print_table

from itrci_nav_msgs.msg import EdgeState, ExecutionRouteStates

ROOT = Path(__file__).resolve().parents[2]
RATE, SECONDS, RUNS = 10.0, 10.0, 3
SHORT, LONG, FORGED = 24, 10_000, 1_000_000  # edges
Reports = Iterator[ExecutionRouteStates]


class Load(NamedTuple):
    """The node's load from some reports: largest growth of memory (MB), and share of a core."""

    growth: float
    share: float


def advancing(edges: int) -> Reports:
    """Yields reports of one route; each report has one more complete edge than the previous report.
    """
    ids = [3, 4, 31, -31, -4, -3]
    states = [EdgeState(ids[index % len(ids)], EdgeState.PROCESSING) for index in range(edges)]
    done = 0
    while True:
        yield ExecutionRouteStates(route_id=1, edge_states=states)
        states[done % edges].state = EdgeState.COMPLETE
        done += 1


def with_forged(edges: int) -> Reports:
    """Yields the same reports, but every twentieth one is forged and has a million edges."""
    forged = ExecutionRouteStates(route_id=2, edge_states=[EdgeState(3, 1)] * FORGED)
    for number, report in enumerate(advancing(edges)):
        yield forged if number % 20 == 19 else report


def measure(reports: Callable[[], Reports]) -> Load:
    """Starts a new node, and sends `reports` to it for a while."""
    node = subprocess.Popen(
        [str(ROOT / 'src/omron_ld90/nodes/route_visualisation'), '__ns:=omron_ld90',
         f'_graph_file:={ROOT}/maps/lab_graph.yaml', '_dock_vertex:=16'],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    publisher = rospy.Publisher('/omron_ld90/execution_route_states', ExecutionRouteStates,
                                queue_size=2)
    try:
        while publisher.get_num_connections() == 0:
            time.sleep(0.05)
        before, largest = resident(node.pid), 0
        used, begin = cpu_seconds(node.pid), time.monotonic()
        for report in reports():
            publisher.publish(report)
            largest = max(largest, resident(node.pid))
            if time.monotonic() - begin > SECONDS:
                break
            time.sleep(1.0 / RATE)
        share = (cpu_seconds(node.pid) - used) / (time.monotonic() - begin)
        return Load((largest - before) / 1e6, share)
    finally:
        publisher.unregister()
        node.send_signal(signal.SIGINT)
        node.wait(10)


def median(reports: Callable[[], Reports]) -> Load:
    """Returns the median of several runs."""
    growths, shares = zip(*(measure(reports) for _ in range(RUNS)))
    return Load(statistics.median(growths), statistics.median(shares))


def main() -> None:
    """Prints the table."""
    with own_ros_master():
        rospy.init_node('bench', disable_signals=True)
        print_table(
            ((name, f'{load.growth:.0f} MB', f'{100 * load.share:.0f} %')
             for name, load in ((name, median(reports)) for name, reports in (
                 (f'a route of {SHORT} edges (floor)', lambda: advancing(SHORT)),
                 (f'a route of {LONG:,} edges', lambda: advancing(LONG)),
                 (f'the same, and a forged report of {FORGED:,} edges every 2 s',
                  lambda: with_forged(LONG))))),
            (f'`route_visualisation`, reports at {RATE:g} Hz for {SECONDS:g} s', 'memory grew by',
             'share of a core'))


if __name__ == '__main__':
    main()
