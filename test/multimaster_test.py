#!/usr/bin/env python3
"""A fleet manager under its own ROS master drives robots that run under others.

Each master has a loopback address of its own; nothing leaves the loopback interface. The simulated
LD-90 is no part of any computer: like a real one, it goes on when its computer dies.
"""
from __future__ import annotations

import os
import re
import shutil
import subprocess
import unittest
from pathlib import Path
from typing import Set

import yaml
from joined_fleet import LD90, JoinedFleet, Odometer, kept_folder
from joined_masters import CROSSING, Computer, has_fkie, program

import itrci_nav_msgs
from system_support import run_cases, wait_until

DESTINATIONS = [18, 39, 52, 6, 16]
SIM_SPEED = 8.0


class JoinedMasters(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        print('ROS masters are joined by', 'fkie multimaster' if has_fkie() else
              'the tests\' own mirror, as fkie multimaster is not there: '
              + os.environ.get('MULTIMASTER_MISSING', 'run scripts/multimaster.sh once'))
        cls.folder = kept_folder('multimaster')
        cls.fleet = JoinedFleet(cls.folder, SIM_SPEED, agvs=2)
        cls.fleet.__enter__()
        cls.addClassCleanup(cls.fleet.__exit__)
        agv_1, cls.newcomer = cls.fleet.agvs
        for computer in (cls.fleet.robot, cls.fleet.manager, agv_1):
            computer.start()

    def test_1_a_mission_across_two_masters(self) -> None:
        mission = self.fleet.send(*DESTINATIONS)
        with Odometer(self.fleet) as odometer:
            done = self.fleet.succeeded(mission)
        self.assertEqual((done.robot, done.reached), (LD90, len(DESTINATIONS)))
        self.assertEqual(self.fleet.sent_to_ld90('dock'), ['dock'])
        type(self).undisturbed = odometer.metres

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
        for here, there in (sides, sides[::-1]):
            checked = here.run('rosrun', 'graph_fleet_manager', 'check_network', there.address,
                               '--master-port', there.port)
            self.assertEqual(checked.returncode, 0, checked.stdout)
            self.assertIn('message definitions are alike', checked.stdout)

    def test_4_a_mission_outlives_the_death_of_either_side_and_of_both(self) -> None:
        fleet = self.fleet
        gone_to = len(fleet.sent_to_ld90('goto'))
        docked = len(fleet.sent_to_ld90('dock'))
        mission = fleet.send(*DESTINATIONS)
        with Odometer(fleet) as odometer:
            for reached, dying in enumerate(([fleet.manager], [fleet.robot],
                                             [fleet.manager, fleet.robot])):
                fleet.wait_for_mission(mission, f'{reached} reached',
                                       lambda line, count=reached: line.reached >= count)
                odometer.wait_for(1.0)
                for computer in dying:
                    computer.kill()
                odometer.wait_for_rest_or(0.5)   # nobody stops what is being driven
                for computer in dying:
                    computer.start()
            done = fleet.succeeded(mission)
        self.assertEqual(done.reached, len(DESTINATIONS))
        self.assertAlmostEqual(odometer.metres, self.undisturbed, delta=3.0,
                               msg='driven, undisturbed and disturbed (m)')
        drives = fleet.sent_to_ld90('goto')[gone_to:]
        repeated = [one for one, other in zip(drives, drives[1:]) if one == other]
        self.assertEqual(repeated, [], drives)
        self.assertEqual(len(fleet.sent_to_ld90('dock')) - docked, 1)

    def test_5_a_robot_that_joins_with_other_definitions_is_named_and_one_with_the_same_drives(
            self) -> None:
        newcomer, manager = self.newcomer, self.fleet.manager
        if has_fkie():
            newcomer.python_path = str(other_definitions(self.folder / 'python'))
            newcomer.start()
            self.wait_for_diagnosis(manager, newcomer, 'other definitions of '
                                                       'itrci_nav_msgs/TargetRoute')
            newcomer.kill()
            newcomer.python_path = ''
        newcomer.start()
        missions = [self.fleet.send(10, robot='agv_1'), self.fleet.send(35, robot='agv_2')]
        for mission in missions:
            self.fleet.succeeded(mission)
        if has_fkie():
            self.wait_for_diagnosis(manager, newcomer, 'message: "joined"')

    def wait_for_diagnosis(self, here: Computer, there: Computer, words: str) -> None:
        """Until /diagnostics says so of a peer: within 10 s of its discovery being there."""
        file = self.folder / 'diagnostics.log'
        file.write_text('')
        with program('rostopic', 'echo', '/diagnostics', log=file, env=here.environment):
            wait_until(lambda: subprocess.run(
                ['rosnode', 'ping', '-c', '1', '/master_discovery'], env=there.environment,
                stdout=subprocess.PIPE, text=True, check=False).stdout.count('xmlrpc reply'), 60,
                'the discovery of the newcomer')

            def said() -> bool:
                statuses = file.read_text(errors='replace').split('- \n')
                return any(there.address in one and words in ' '.join(one.split())
                           for one in statuses)
            wait_until(said, 10, f'{words!r} of {there.address} in /diagnostics')

    def skip_without_fkie(self) -> None:
        if not has_fkie():
            self.skipTest('fkie multimaster is not there')


def other_definitions(folder: Path) -> Path:
    """The project's messages, but for one whose definition is another."""
    package = folder / 'itrci_nav_msgs'
    shutil.copytree(Path(itrci_nav_msgs.__path__[0]), package, dirs_exist_ok=True)
    module = package / 'msg' / '_TargetRoute.py'
    text = module.read_text()
    md5 = re.search(r'_md5sum = "(\w+)"', text).group(1)
    module.write_text(text.replace(md5, md5[::-1]))
    return folder


if __name__ == '__main__':
    run_cases(__file__)
