#!/usr/bin/env python3
"""50 random breaks between a fleet manager and a robot: nothing is driven twice, nothing is lost.

The test runs only with scripts/test.sh --long, and if network namespaces are allowed.
MULTIMASTER_SEED repeats a run; MULTIMASTER_BREAKS sets another number of breaks. The file
build/artefacts/multimaster_breaks/breaks.log lists the actions.
"""
from __future__ import annotations

import os
import random
import time
import unittest
from typing import List

from joined_fleet import JoinedFleet, Odometer, kept_folder
from joined_masters import has_fkie
from network_namespaces import Cable, why_not

from system_support import run_cases, wait_until

SIM_SPEED = 4.0
BREAKS = int(os.environ.get('MULTIMASTER_BREAKS', 50))
# number of deaths of each side, and of both at once; all other breaks only cut the link
DEATHS = BREAKS // 12
MISSION = [18, 39, 52, 6, 16]
# m by which the length of the same mission can differ, because the robot does not stop exactly at
# turning points
METRES = 2.0
APART = (0.5, 10.0)  # m that the robot drives between two breaks
AWAY = (0.2, 8.0)     # s for which the link is cut
LATER = (0.0, 2.0)  # s after which a killed computer is started again


class Breaks(unittest.TestCase):

    def setUp(self) -> None:
        if not os.environ.get('LD90_LONG_TESTS'):
            self.skipTest('it takes 15 minutes; scripts/test.sh --long runs it')
        reason = why_not() or ('' if has_fkie() else 'fkie multimaster is not installed')
        if reason:
            self.skipTest(reason)
        seed = int(os.environ.get('MULTIMASTER_SEED', random.randrange(10 ** 6)))
        self.dice = random.Random(seed)
        self.cable = Cable()
        self.cable.__enter__()
        self.addCleanup(self.cable.__exit__)
        folder = kept_folder('multimaster_breaks')
        self.journal = folder / 'breaks.log'
        self.note(f'MULTIMASTER_BREAKS={BREAKS} MULTIMASTER_SEED={seed}')
        self.fleet = JoinedFleet(folder, SIM_SPEED, namespaces=self.cable.namespaces,
                                 addresses=self.cable.addresses, pictures=False)
        self.fleet.__enter__()
        self.addCleanup(self.fleet.__exit__)

    def test_random_breaks_drive_nothing_twice_and_lose_nothing(self) -> None:
        links = BREAKS - 3 * DEATHS
        kinds = (['cable'] * (links // 2) + ['radio'] * (links - links // 2)
                 + ['fleet', 'robot', 'both'] * DEATHS)
        self.dice.shuffle(kinds)
        for computer in self.fleet.computers:
            computer.start()
        undisturbed = self.drive([])
        begun = time.monotonic()
        while kinds:
            driven = self.drive(kinds)
            self.note(f'{BREAKS - len(kinds)} breaks in {time.monotonic() - begun:.0f} s: '
                      f'{driven:.1f} m, undisturbed {undisturbed:.1f} m')
            self.assertAlmostEqual(driven, undisturbed, delta=METRES, msg='driven (m)')

    def note(self, text: str) -> None:
        """Writes a line to the file of actions, for the analysis of failures."""
        with self.journal.open('a') as journal:
            journal.write(f'{text}\n')

    def drive(self, kinds: List[str]) -> float:
        """Drives one mission with breaks, taken from the end of `kinds`. Returns the metres driven.
        """
        fleet = self.fleet
        gone_to, docked = len(fleet.sent_to_ld90('goto')), len(fleet.sent_to_ld90('dock'))
        with Odometer(fleet) as odometer:
            mission = fleet.send(*MISSION)
            while kinds:
                begun, far = odometer.metres, self.dice.uniform(*APART)
                wait_until(lambda begun=begun, far=far: odometer.metres - begun >= far
                           or not fleet.is_open(mission), 180, f'the robot drives {far:.1f} m')
                if not fleet.is_open(mission):
                    break
                self.break_off(kinds.pop())
            fleet.succeeded(mission, 240.0)
            driven = odometer.metres
        drives = fleet.sent_to_ld90('goto')[gone_to:]
        repeated = [one for one, other in zip(drives, drives[1:]) if one == other]
        self.assertEqual(repeated, [], drives)
        self.assertEqual(len(fleet.sent_to_ld90('dock')) - docked, 1)
        return driven

    def break_off(self, kind: str) -> None:
        """Makes one break. Its length, and the side that returns first, are random."""
        self.note(kind)
        if kind in ('cable', 'radio'):
            with self.cable.pulled() if kind == 'cable' else self.cable.in_radio_shadow():
                time.sleep(self.dice.uniform(*AWAY))
            return
        fleet = self.fleet
        dying = {'fleet': [fleet.manager], 'robot': [fleet.robot],
                 'both': [fleet.manager, fleet.robot]}[kind]
        for computer in dying:
            computer.kill()
        for computer in self.dice.sample(dying, len(dying)):
            time.sleep(self.dice.uniform(*LATER))
            computer.start()


if __name__ == '__main__':
    run_cases(__file__)
