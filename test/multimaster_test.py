#!/usr/bin/env python3
"""A fleet manager under its own ROS master drives robots that run under others.

Each master has a loopback address of its own; nothing leaves the loopback interface. The simulated
LD-90 is no part of any computer: like a real one, it goes on when its computer dies.
"""
from __future__ import annotations

import os
import re
import unittest

import yaml
from joined_fleet import LD90, JoinedFleet, Odometer, kept_folder
from joined_masters import CROSSING, has_fkie

from system_support import run_cases, wait_until

DESTINATIONS = [18, 39, 52, 6, 16]
SIM_SPEED = 6.0


class JoinedMasters(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        print('ROS masters are joined by', 'fkie multimaster' if has_fkie() else
              'the tests\' own mirror, as fkie multimaster is not there: '
              + os.environ.get('MULTIMASTER_MISSING', 'run scripts/multimaster.sh once'))
        cls.fleet = JoinedFleet(kept_folder('multimaster'), SIM_SPEED)
        cls.fleet.__enter__()
        cls.addClassCleanup(cls.fleet.__exit__)
        for computer in cls.fleet.computers:
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
        robot, manager = self.fleet.robot, self.fleet.manager
        own = f'/{LD90}/'
        for here, there, must in (
                (manager, robot, {f'{own}target_route', f'{own}execution_route_states',
                                  f'{own}route_refused', f'{own}battery_state'}),
                (robot, manager, {'/fleet_state', '/mission_status', '/graph', '/fleet_plan'})):
            wait_until(lambda here=here, there=there, must=must: must <= here.topics_of(there), 60,
                       f'{must} of {there.name} on {here.name}')
            strange = {topic for topic in here.topics_of(there) if not wanted.match(topic)}
            self.assertEqual(strange, set(), f'topics that crossed to {here.name}')

    def test_3_a_mission_outlives_the_death_of_either_side_and_of_both(self) -> None:
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
                odometer.wait_for(0.5)   # nobody stops what is being driven
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


if __name__ == '__main__':
    run_cases(__file__)
