#!/usr/bin/env python3
"""Measures two ROS masters that fkie multimaster joins: recovery, lost messages, bytes on the link.

An LD-90 with its computer and a fleet manager run in two network namespaces, which a virtual cable
connects. This needs root. The host's own network is not changed.
"""
from __future__ import annotations

import argparse
import contextlib
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Callable, ContextManager, Iterator, List, Tuple

from joined_fleet import LD90, JoinedFleet, Odometer
from joined_masters import Computer, has_fkie
from measuring.tables import print_row, print_table
from network_namespaces import Cable, entering, inside, why_not

from system_support import wait_until

HERE = Path(__file__).resolve().parent
REPORTS = (f'/{LD90}/execution_route_states', 'itrci_nav_msgs/ExecutionRouteStates')
STATES = ('/fleet_state', 'itrci_nav_msgs/FleetState')
AWAY = (1.0, 5.0, 15.0)  # s without the link
DEATHS = 2  # how often each side is killed
COUNTED = 10.0  # s in which bytes are counted


class Listener:
    """Receives a topic from all publishers, in a separate process on one of the computers."""

    def __init__(self, computer: Computer, namespace: str, topic: Tuple[str, str]) -> None:
        self.heard: List[Tuple[float, int]] = []
        self._process = subprocess.Popen(
            [*entering(namespace), sys.executable, str(HERE / 'multimaster_bench/listener.py'),
             *topic], env=computer.environment, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True)
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        for line in self._process.stdout or ():
            moment, number = line.split()
            self.heard.append((float(moment), int(number)))

    def close(self) -> None:
        """Ends the listener."""
        self._process.terminate()
        self._process.wait(10)

    def first_after(self, moment: float) -> float:
        """Returns when the next message after `moment` arrived."""
        return wait_until(lambda: next((at for at, _ in self.heard if at > moment), None), 60,
                          'a message across the link')

    def lost_since(self, moment: float) -> int:
        """Returns how many messages of a publisher were lost since `moment`, from the gaps in their
        numbers.

        A gap after the last message before `moment` counts, too.
        """
        before = [number for at, number in self.heard if at < moment]
        numbers = before[-1:] + [number for at, number in self.heard if at >= moment]
        return sum(later - number - 1 for number, later in zip(numbers, numbers[1:])
                   if later > number)


@contextlib.contextmanager
def listening(computer: Computer, namespace: str, topic: Tuple[str, str]) -> Iterator[Listener]:
    """Yields a listener that has already received a message."""
    wait_until(lambda: inside(namespace, lambda: computer.publishes(topic[0])), 120,
               f'{topic[0]} at the master of {computer.name}')
    listener = Listener(computer, namespace, topic)
    try:
        wait_until(lambda: listener.heard, 60, f'{topic[0]} on {computer.name}')
        yield listener
    finally:
        listener.close()


def without_link(broken: Callable[[], ContextManager[None]], listener: Listener
                 ) -> List[Tuple[float, float, int]]:
    """Breaks the link several times. Returns for each break its length (s), the time (s) from the
    repair to the next report, and the number of lost reports.
    """
    found = []
    for seconds in AWAY:
        before = time.monotonic()
        with broken():
            time.sleep(seconds)
        back = time.monotonic()
        came = listener.first_after(back)
        listener.first_after(came)
        found.append((seconds, came - back, listener.lost_since(before)))
    return found


def died(side: Computer, namespace: str, topic: str, listener: Listener
         ) -> List[Tuple[float, float]]:
    """Kills a side several times. Returns for each death the time (s) until the side runs again,
    and then the time (s) until its first message.
    """
    found = []
    for _ in range(DEATHS):
        side.kill()
        side.start()
        begun = time.monotonic()
        wait_until(lambda: inside(namespace, lambda: side.publishes(topic)), 120,
                   f'{topic} of {side.name} at its own master')
        up = time.monotonic()
        found.append((up - begun, max(listener.first_after(begun) - up, 0.0)))
    return found


def rate(cable: Cable) -> Tuple[float, float]:
    """Returns the bytes per second on the link now, from the robot and to the robot."""
    before, begun = cable.bytes_sent(), time.monotonic()
    time.sleep(COUNTED)
    passed = time.monotonic() - begun
    there, back = ((after - first) / passed for after, first in zip(cable.bytes_sent(), before))
    return there, back


def seconds(values: List[float]) -> str:
    """Returns a text with the least, the median and the largest value."""
    return ' / '.join(f'{value:.2f}' for value in (
        min(values), statistics.median(values), max(values))) + ' s'


def measure(fleet: JoinedFleet, cable: Cable) -> None:
    """Measures everything, one after the other."""
    robot, manager = cable.namespaces
    for computer in fleet.computers:
        computer.start()
    with listening(fleet.manager, manager, REPORTS) as reports:
        standing = rate(cable)
        fleet.send(18, 39, 52, 6, 16)
        with Odometer(fleet) as odometer:
            odometer.wait_for(1.0)
            driving = rate(cable)
            for name, broken in (('cable pulled', cable.pulled),
                                 ('radio shadow', cable.in_radio_shadow)):
                for away, recovered, lost in without_link(broken, reports):
                    print_row((f'{name} for {away:.0f} s: next report after the link is back',
                               f'{recovered:.2f} s, {lost} reports lost', '< 3 s'))
        up, crossed = zip(*died(fleet.robot, robot, REPORTS[0], reports))
    print_row(('robot\'s computer dead and started anew: its own start', seconds(list(up)), ''))
    print_row(('from that moment until its first report crosses the link',
               seconds(list(crossed)), '< 3 s'))
    with listening(fleet.robot, robot, STATES) as states:
        up, crossed = zip(*died(fleet.manager, manager, STATES[0], states))
    print_row(('fleet\'s computer dead and started anew: its own start', seconds(list(up)), ''))
    print_row(('from that moment until its first fleet state crosses the link',
               seconds(list(crossed)), '< 3 s'))
    for name, (there, back) in (('standing', standing), ('driving', driving)):
        print_row((f'across the link for one {name} robot: from it / to it',
                   f'{there / 1000:.1f} / {back / 1000:.1f} kB/s', '< 20 kB/s'))


def main() -> None:
    """Prints the table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    reason = why_not() or ('' if has_fkie() else 'fkie multimaster is not installed; '
                                                 'run scripts/multimaster.sh')
    if reason:
        print(f'Skipped: {reason}.')
        return
    print_table([], ('two ROS masters, fkie multimaster, real time', 'least / median / most',
                     'goal'))
    with tempfile.TemporaryDirectory() as folder, Cable() as cable, JoinedFleet(
            Path(folder), 1.0, namespaces=cable.namespaces, addresses=cable.addresses,
            pictures=False) as fleet:
        measure(fleet, cable)


if __name__ == '__main__':
    main()
