#!/usr/bin/env python3
"""A fleet manager under its own ROS master drives robots under other ROS masters.

Each master has its own loopback address, and nothing leaves the loopback interface. The simulated
LD-90 belongs to no computer: like a real robot, it continues when its computer is killed.
"""
from __future__ import annotations

import contextlib
import os
import re
import shutil
import unittest
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Callable, Iterator, Set

import yaml
from joined_fleet import LD90, JoinedFleet, Odometer, kept_folder
from joined_masters import CROSSING, Computer, has_fkie, program

import itrci_nav_msgs
from graph_fleet_manager.multimaster.peer_master import Discovery, NoAnswer
from system_support import run_cases, wait_until

DESTINATIONS = [18, 39, 52, 6, 16]
SIM_SPEED = 8.0
LONG = bool(os.environ.get('LD90_LONG_TESTS'))


class JoinedMasters(unittest.TestCase):
    """The LD-90's computer starts before the fleet manager's, and agv_1's computer starts later.

    With --long, agv_2's computer also starts before the fleet manager's, and agv_1 at first has
    another definition of a message. agv_1 stands where it blocks no other robot.
    """

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = kept_folder('multimaster')
        cls.fleet = JoinedFleet(cls.folder, SIM_SPEED, agvs=2 if LONG else 1, pictures=False,
                                absent='agv_1')
        cls.fleet.__enter__()
        cls.addClassCleanup(cls.fleet.__exit__)
        cls.newcomer, *others = cls.fleet.agvs
        for computer in (cls.fleet.robot, *others):
            computer.start()
        for computer in (cls.fleet.robot, *others):
            wait_until(partial(computer.publishes, f'/{computer.name}/execution_route_states'), 90,
                       f'{computer.name} reports to its own master')

    def test_1_a_fleet_manager_that_comes_later_drives_a_robot_that_was_there_before(self) -> None:
        self.fleet.manager.start()
        with Odometer(self.fleet) as odometer:
            mission = self.fleet.send(*DESTINATIONS)
            if LONG and has_fkie():
                self.name_who_has_other_definitions()
            done = self.fleet.succeeded(mission)
            type(self).undisturbed = odometer.metres
        self.assertEqual((done.robot, done.reached), (LD90, len(DESTINATIONS)))
        self.assertEqual(self.fleet.sent_to_ld90('dock'), ['dock'])

    def name_who_has_other_definitions(self) -> None:
        """Lets a robot with other message definitions join. Checks that /diagnostics names it
        within 10 s after it was discovered, and that the missions of other robots go on.
        """
        newcomer = self.newcomer
        newcomer.python_path = str(other_definitions(self.folder / 'python'))
        with self.diagnostics() as said:
            wait_until(lambda: said(newcomer, 'it does not answer'), 60,
                       'the watch reports that the newcomer is missing')
            newcomer.start()
            wait_until(lambda: answers(newcomer.address), 60, 'the discovery of the newcomer')
            wait_until(lambda: said(newcomer, 'other definitions of itrci_nav_msgs/TargetRoute'),
                       10, 'its definitions in /diagnostics')

    @contextlib.contextmanager
    def diagnostics(self) -> Iterator[Callable[[Computer, str], bool]]:
        """Yields a function that waits for a text about a peer in the fleet manager's /diagnostics.

        The function returns whether the text came.
        """
        file = self.folder / 'diagnostics.log'
        file.write_text('')

        def said(peer: Computer, words: str) -> bool:
            statuses = ' '.join(file.read_text(errors='replace').split()).split('level:')
            return any(f'peer_watch: {peer.address}' in one and words in one for one in statuses)
        with program('rostopic', 'echo', '/diagnostics', log=file,
                     env=self.fleet.manager.environment):
            yield said

    def test_2_only_what_is_listed_crosses(self) -> None:
        wanted = re.compile('|'.join(topic.replace('*', '[^/]+') for topic in yaml.safe_load(
            CROSSING.read_text())['sync_topics']) + r'\Z')
        for here, there, must in (
                (self.fleet.manager, self.fleet.robot,
                 {f'/{LD90}/{topic}' for topic in ('target_route', 'execution_route_states',
                                                   'route_refused', 'battery_state')}),
                (self.fleet.robot, self.fleet.manager,
                 {'/fleet_state', '/mission_status', '/graph', '/fleet_plan'})):
            self.wait_for_topics(here, there, must)
            strange = {topic for topic in here.topics_of(there) if not wanted.match(topic)}
            self.assertEqual(strange, set(), f'topics that crossed to {here.name}')

    @staticmethod
    def wait_for_topics(here: Computer, there: Computer, must: Set[str]) -> None:
        wait_until(lambda: must <= here.topics_of(there), 60,
                   f'{must} of {there.name} on {here.name}')

    def test_3_the_network_is_found_well_from_either_side(self) -> None:
        self.skip_without_fkie()
        sides = (self.fleet.robot, self.fleet.manager)
        with ThreadPoolExecutor() as at_once:
            found = at_once.map(lambda here, there: here.run(
                'rosrun', 'graph_fleet_manager', 'check_network', there.address,
                '--master-port', there.port), sides, sides[::-1])
            for checked in found:
                self.assertEqual(checked.returncode, 0, checked.stdout)
                self.assertIn('message definitions are alike', checked.stdout)

    def test_4_a_mission_outlives_the_death_of_either_side(self) -> None:
        """With --long, both sides are also killed at once. Meanwhile a new robot joins."""
        fleet = self.fleet
        deaths = [[fleet.manager], [fleet.robot]]
        if LONG:
            deaths.append([fleet.manager, fleet.robot])
        gone_to = len(fleet.sent_to_ld90('goto'))
        docked = len(fleet.sent_to_ld90('dock'))
        self.newcomer.kill()
        self.newcomer.python_path = ''
        with Odometer(fleet) as odometer:
            mission = fleet.send(*DESTINATIONS)
            for reached, dying in enumerate(deaths):
                fleet.wait_for_mission(mission, f'{reached} reached',
                                       lambda line, count=reached: line.reached >= count)
                odometer.wait_for(1.0)
                for computer in dying:
                    computer.kill()
                odometer.wait_for_rest_or(0.5)  # the present drive must not be stopped
                for computer in dying:
                    computer.start()
            self.newcomer.start()
            done = fleet.succeeded(mission)
            driven = odometer.metres
        self.assertEqual(done.reached, len(DESTINATIONS))
        self.assertAlmostEqual(driven, self.undisturbed, delta=3.0,
                               msg='driven, undisturbed and disturbed (m)')
        drives = fleet.sent_to_ld90('goto')[gone_to:]
        repeated = [one for one, other in zip(drives, drives[1:]) if one == other]
        self.assertEqual(repeated, [], drives)
        self.assertEqual(len(fleet.sent_to_ld90('dock')) - docked, 1)

    def test_5_the_robots_of_all_masters_drive(self) -> None:
        """One of the robots has joined while the fleet manager was running."""
        missions = [self.fleet.send(vertex, robot=computer.name)
                    for computer, vertex in zip(self.fleet.agvs, (10, 35))]
        for mission in missions:
            self.fleet.succeeded(mission)

    def skip_without_fkie(self) -> None:
        if not has_fkie():
            self.skipTest('fkie multimaster is not installed')


def answers(address: str) -> bool:
    """Returns whether the discovery at this address answers."""
    try:
        Discovery(address).clock()
    except NoAnswer:
        return False
    return True


def other_definitions(folder: Path) -> Path:
    """Writes the definitions of the project's messages, and changes one definition. Returns the
    folder.
    """
    package = folder / 'itrci_nav_msgs'
    shutil.copytree(Path(itrci_nav_msgs.__path__[0]), package, dirs_exist_ok=True)
    module = package / 'msg' / '_TargetRoute.py'
    text = module.read_text()
    md5 = re.search(r'_md5sum = "(\w+)"', text).group(1)
    module.write_text(text.replace(md5, md5[::-1]))
    return folder


if __name__ == '__main__':
    run_cases(__file__)
