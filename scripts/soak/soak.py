#!/usr/bin/env python3
"""Runs a simulated fleet for hours with many kinds of faults. A witness judges the fleet.

The robots are several times as fast as real ones; all software runs in real time. The same seed
gives the same missions, faults and pauses, but at times that depend on the computer.
"""
from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
import threading
import time
from pathlib import Path
from random import Random
from typing import Any, Callable, Dict, List

from ros_master import RosMaster
from soaking.disturbances import Disturbances
from soaking.fleet import Fleet
from soaking.hall import CLEARANCE, Hall, write_hall
from soaking.launch import PLANTS, Launch, resources
from soaking.simulators import Simulators
from soaking.work import PRESS, SoakPlc

from itrci_nav_msgs.msg import FleetRobot, MissionCommand, MissionStep, MissionStop
from world.witness import Witness, growth

ROOT = Path(__file__).resolve().parents[2]
LOG = ROOT / 'build/soak.log'
READY = (FleetRobot.IDLE, FleetRobot.BUSY)
READY_WITHIN = 150.0  # s after the start within which all robots must be ready
LOOK = 0.04  # s between two samples of the robots' positions
GRACE = 6.0  # s after a stop within which a robot with a connection must stand
SAMPLE = 5.0  # s between two samples of memory, threads, sockets and files
LAST = 240.0  # s after the last fault within which open missions must end
KINDS = ('memory, MB', 'threads', 'sockets', 'files')
GROWTH = {'memory, MB': (0.15, 40.0), 'threads': (0.1, 20.0), 'sockets': (0.1, 20.0),
          'files': (0.1, 20.0)}
JOURNAL = 12e6, 10e3  # permitted bytes of the journal and its log: without missions, per mission


class Soak:
    """One soak run."""

    def __init__(self, given: argparse.Namespace, folder: Path, master: RosMaster) -> None:
        self._given = given
        self._chance = Random(given.seed)
        self._lock = threading.RLock()
        self._ended = threading.Event()
        self._over = threading.Event()
        self._samples: Dict[str, List[float]] = {kind: [] for kind in KINDS}
        self.site = SoakPlc()
        self.site.start()
        self.hall: Hall = write_hall(folder, given.ld90s, given.agvs, self.site.port)
        self.witness = Witness(self.hall.radii, CLEARANCE, self.hall.places, GRACE)
        self.launch = Launch(self.hall.words, given.speed, folder, LOG, given.plant)
        self.fleet = Fleet(self.witness, self._lock, given.seed, given.corrupted)
        self._master = master
        self._errors: List[str] = []
        self._sent = self._worked = self._answered = 0

    def run(self) -> bool:
        """Runs the soak. Returns whether each promise held. Raises SystemExit if the fleet does not
        start.
        """
        names = set(self.hall.radii)
        if not self.fleet.wait_for(lambda: self.fleet.is_connected and names <= {
                name for name, robot in self.fleet.robots().items() if robot.state in READY},
                READY_WITHIN):
            print(f'The fleet was not ready within {READY_WITHIN:.0f} s: see its log, {LOG}')
            sys.exit(2)
        port = self.launch.control_port
        self.simulators = Simulators(port, port + 1)
        self.disturbances = Disturbances(
            self.hall, self.simulators, self.fleet, self.witness, self._lock, self.launch,
            self._master, self._given.speed, self._given.seed, self._ended,
            self.site)
        threads = [threading.Thread(target=self._guarded, args=(work,), daemon=True)
                   for work in (self._watch, self._send, self._help, self._answer,
                                self._sample, self._disturb)]
        begun = time.monotonic()
        for thread in threads:
            thread.start()
        self._wait_until_over(begun + 3600.0 * self._given.hours)
        if not self.launch.is_running:
            self._errors.append(f'roslaunch ended during the soak: see its log, {LOG}')
        self._ended.set()
        threads[-1].join(120.0)
        self._end(begun)
        self._over.set()
        for thread in threads[:-1]:
            thread.join(30.0)
        self._judge_growth()
        self._judge_press()
        self._report(time.monotonic() - begun)
        return not self.witness.broken and not self._errors

    def _wait_until_over(self, deadline: float) -> None:
        while time.monotonic() < deadline and self.launch.is_running and not self._errors:
            if self.witness.broken and self._given.until_broken:
                return
            time.sleep(0.2)

    def _end(self, begun: float) -> None:
        """Ends all faults, and waits until the open missions have ended."""
        if self.witness.broken and self._given.until_broken:
            return
        self.disturbances.remedy_all()
        self.site.breaks = self.site.lies = False
        self.fleet.wait_for(lambda: not self.witness.open_missions, LAST)
        with self._lock:
            self.witness.end()

    # -- threads -----------------------------------------------------------------------------------

    def _guarded(self, work: Callable[[], None]) -> None:
        try:
            work()
        except Exception as error:  # the error ends the run, and the report shows it
            self._errors.append(f'{work.__name__}: {type(error).__name__}: {error}')
            raise

    def _watch(self) -> None:
        while not self._over.wait(LOOK):
            first, second = self.simulators.places_twice()
            with self._lock:
                self.witness.judge(time.monotonic(), first, second)

    def _send(self) -> None:
        while not self._ended.wait(0.3):
            with self._lock:
                is_due = len(self.witness.open_missions) < len(self.hall.radii)
            if is_due:
                count = self._chance.choice((1, 1, 2))
                more: Dict[str, Any] = {}
                if self._chance.random() < 0.2:
                    more['robot'] = self._chance.choice(sorted(self.hall.radii))
                if self._chance.random() < 0.3:
                    more['dwell'] = [self._chance.choice((0.0, 0.5, 2.0))] * count
                chosen = self._chance.sample(self.hall.stations, count)
                if self._chance.random() < 0.4:
                    more = self._with_steps(chosen)
                self.fleet.send(chosen, priority=self._chance.choice((0, 0, 0, 5)), **more)
                self._sent += 1
            self.fleet.repeat_unanswered()
        while not self._over.wait(1.0):
            self.fleet.repeat_unanswered()

    def _with_steps(self, stations: List[int]) -> Dict[str, Any]:
        """Returns the fields of a request for a mission with steps, except its destinations."""
        self._worked += 1
        press = MissionStep(type='handshake', actor=MissionStep.DEVICE, device=PRESS, timeout=40.0,
                            on_failure=MissionStep.RETRY, retries=1)
        steps = [press]
        if self._chance.random() < 0.5:  # only AGVs carry out steps on their own
            steps.append(MissionStep(type='work', timeout=40.0, on_failure=MissionStep.ASK))
        stops = [MissionStop(vertex=stations[0], steps=steps),
                 *(MissionStop(vertex=vertex) for vertex in stations[1:])]
        return {'stops': stops, **({'robot_type': 'agv'} if len(steps) > 1 else {})}

    def _answer(self) -> None:
        """Plays a person: looks at the press, and answers each step that waits for an answer."""
        while not self._over.wait(1.0):
            with self._lock:
                asking = dict(self.fleet.asking)
            for mission, key in asking.items():
                is_done = key in self.site.done
                self.fleet.answer(mission, key,
                                  MissionCommand.DONE if is_done else self._chance.choice(
                                      (MissionCommand.RETRY, MissionCommand.SKIP)))
                self._answered += 1

    def _help(self) -> None:
        while not self._over.wait(2.0):
            self.disturbances.help_robots()

    def _sample(self) -> None:
        while not self._over.wait(SAMPLE):
            for kind, value in zip(KINDS, resources(self.launch.pids())):
                self._samples[kind].append(value)

    def _disturb(self) -> None:
        self.disturbances.run(self._given.only)

    # -- the end -----------------------------------------------------------------------------------

    def _judge_growth(self) -> None:
        for kind, (share, least) in GROWTH.items():
            grown = growth(self._samples[kind], share, least)
            if grown:
                self.witness.broken.append(
                    f'{kind}: grew from {grown[0]:.0f} to {grown[1]:.0f}')
        most, each = JOURNAL
        size = self.journal_size
        if size > most + each * self._sent:
            self.witness.broken.append(f'the journal has {size} bytes after {self._sent} missions')

    def _judge_press(self) -> None:
        """Checks that the press was started at most once with each key, even if programs were
        killed and restarted.
        """
        self.witness.broken += [f'the press was started again with the key {key}'
                                for key in sorted(self.site.repeated)]

    @property
    def journal_size(self) -> int:
        """Returns the size of the journal with its write-ahead log, in bytes."""
        return sum(file.stat().st_size for file in self.launch.folder.glob('fleet.sqlite*'))

    def _report(self, seconds: float) -> None:
        print(f'{self._given.ld90s} LD-90s and {self._given.agvs} AGVs at {self._given.speed:g} '
              f'times their speed, seed {self._given.seed}, {seconds / 60.0:.1f} minutes; '
              f'driven {sum(self.witness.driven.values()) / 1000.0:.1f} km')
        ends = ', '.join(f'{count} {state.name.lower()}'
                         for state, count in self.witness.ends().items())
        print(f'missions: {self._sent} sent; {ends}')
        print(f'missions with steps: {self._worked}; the press was started '
              f'{sum(self.site.started.values())} times and has handed over '
              f'{len(self.site.done)} times; {self._answered} answers of persons')
        print(f'disturbances: {dict(sorted(self.disturbances.done.items()))}')
        print(f'plan answers: {self.fleet.answers}, of these made wrong: '
              f'{self.fleet.wrong_answers}')
        print(f'position samples: {self.witness.looks}; smallest free space between two robots, '
              f'minus the clearance: {self.witness.nearest:.2f} m')
        for kind, values in self._samples.items():
            if values:
                print(f'{kind}: at the start {values[0]:.0f}, highest {max(values):.0f}, '
                      f'at the end {values[-1]:.0f}')
        print(f'journal: {self.journal_size / 1e6:.2f} MB')
        if self._given.verbose:
            print('\n'.join(self.disturbances.notes))
        for words in [*self._errors, *self.witness.broken]:
            print(f'BROKEN: {words}')
        print('every promise held' if not self.witness.broken + self._errors else
              'not every promise held')


def main() -> None:
    """Runs the command."""
    parser = argparse.ArgumentParser(prog='scripts/soak.sh', description=__doc__)
    parser.add_argument('hours', nargs='?', type=float, default=1.0)
    parser.add_argument('--seed', type=int, default=1, help='seed of all random choices')
    parser.add_argument('--ld90s', type=int, default=10)
    parser.add_argument('--agvs', type=int, default=10)
    parser.add_argument('--speed', type=float, default=5.0,
                        help='speed of the robots, as a multiple of real ones')
    parser.add_argument('--corrupted', type=float, default=0.1,
                        help='share (0..1) of plan answers that are made wrong')
    parser.add_argument('--only', nargs='+', default=[],
                        help='cause only these kinds of disturbances')
    parser.add_argument('--plant', default='',
                        help=f'name of a defect in {PLANTS}/sitecustomize.py to plant')
    parser.add_argument('--until-broken', action='store_true',
                        help='end the run at the first broken promise')
    parser.add_argument('--verbose', action='store_true', help='list all disturbances')
    given = parser.parse_args()
    LOG.parent.mkdir(exist_ok=True)
    folder = Path(tempfile.mkdtemp(prefix='soak_'))
    os.environ['ROS_HOME'] = str(folder / 'ros_home')
    master = RosMaster()
    os.environ['ROS_MASTER_URI'] = master.uri
    soak = None
    try:
        soak = Soak(given, folder, master)
        held = soak.run()
    finally:
        if soak is not None:
            soak.launch.stop()
            soak.site.kill()
            shutil.rmtree(soak.launch.folder, ignore_errors=True)
        master.kill()
        shutil.rmtree(folder, ignore_errors=True)
    sys.exit(0 if held else 1)


if __name__ == '__main__':
    main()
