#!/usr/bin/env python3
"""Fleet manager and robot on separate computers; their cable is pulled during a drive."""
from __future__ import annotations

import time
import unittest

from joined_fleet import LD90, JoinedFleet, Odometer, kept_folder
from joined_masters import has_fkie
from network_namespaces import Cable, why_not

from system_support import run_cases

SIM_SPEED = 8.0
DESTINATIONS = [18, 16]
PULLED = 20.0  # s


class PulledCable(unittest.TestCase):

    def setUp(self) -> None:
        reason = why_not() or ('' if has_fkie() else 'fkie multimaster is not installed')
        if reason:
            self.skipTest(reason)

    def test_the_route_goes_on_without_the_link_and_the_mission_with_it(self) -> None:
        with Cable() as cable, JoinedFleet(
                kept_folder('multimaster_network'), SIM_SPEED, namespaces=cable.namespaces,
                addresses=cable.addresses, pictures=False) as fleet:
            for computer in fleet.computers:
                computer.start()
            with Odometer(fleet) as odometer:
                mission = fleet.send(*DESTINATIONS)
                odometer.wait_for(3.0)
                with cable.pulled():
                    until = time.monotonic() + PULLED
                    odometer.wait_for_rest_or(2.0)  # the robot drives its present route
                    time.sleep(until - time.monotonic())
                    reached = fleet.mission(mission).reached
                done = fleet.succeeded(mission)
            self.assertLess(reached, len(DESTINATIONS), 'mission ended while cable was pulled')
            self.assertEqual((done.robot, done.reached), (LD90, len(DESTINATIONS)))
            drives = fleet.sent_to_ld90('goto')
            repeated = [one for one, other in zip(drives, drives[1:]) if one == other]
            self.assertEqual(repeated, [], drives)
            self.assertEqual(fleet.sent_to_ld90('dock'), ['dock'])


if __name__ == '__main__':
    run_cases(__file__)
