"""Drives and docking, with all lines that the robot sends about them."""
from __future__ import annotations

from pathlib import Path
from typing import Optional

import numpy as np
import pytest
from motion_inspector import Inspector
from sim_builders import MAPS, Obstacles, Rig, room

from omron_ld90_sim.interface.faults import Faults
from omron_ld90_sim.motion.base import STEP
from omron_ld90_sim.motion.kinematics import LD90_LIMITS, normalise
from omron_ld90_sim.motion.space import Disc
from omron_ld90_sim.motion.track import Turn
from omron_map import MapDocument


@pytest.mark.parametrize('path', [None, *MAPS], ids=lambda path: path.stem if path else 'room')
def test_no_fault_and_no_task_makes_the_robot_break_a_limit(path: Optional[Path]) -> None:
    if path and not path.exists():
        pytest.skip(f'{path.name} does not exist')
    document = MapDocument.load(str(path)) if path else room()
    first, goals = document.goals[0], document.goals
    rig = Rig(document, start=(first.x, first.y, 0.0), seed=6)
    inspector = Inspector(Obstacles(document), rig.robot.base)
    faults, random = Faults(rig.server), np.random.RandomState(6)
    for _ in range(120):
        goal = goals[random.randint(len(goals))]
        if random.rand() < 0.2:
            faults.inject(random.choice(['estop press', 'lost', 'motors off', 'block', 'unblock',
                                         'reboot 1']))
        else:  # the robot recovers; a new client connects if necessary
            faults.inject('estop release')
            client, true = rig.client(), rig.robot.true_pose
            client.send('enableMotors', f'localizeToPoint {true.x} {true.y} {true.theta}')
            rig.clock.advance(rig.clock.now + 1.1)
            client.send(random.choice([
                f'goto "{goal.name}"', f'gotoPoint {goal.x} {goal.y} {random.randint(360)}',
                'dock', 'undock', 'stop', f'doTask move {random.randint(-800, 800)}',
                f'doTask setHeading {random.randint(360)}'],
                p=[0.35, 0.3, 0.05, 0.05, 0.1, 0.1, 0.05]))
        rig.clock.advance(rig.clock.now + random.uniform(0.1, 8.0))
    inspector.check(LD90_LIMITS.emergency_deceleration)
    assert inspector.steps > 2000


def test_the_robot_comes_to_rest_within_its_arrival_error() -> None:
    rig = Rig(arrival_error=(30.0, 1.0))
    client, off, turned = rig.client(), [], []
    for _ in range(10):
        for command, x, y in (('goto "East side"', 4500.0, 1500.0),
                              ('gotoPoint -3000 1500 90', -3000.0, 1500.0)):
            client.send(command)
            client.until('Arrived')
            off.append(rig.robot.true_pose.distance_to(x, y))
            turned.append(abs(rig.robot.true_pose.theta - 90.0))
    assert 15.0 < max(off) < 31.0 and 0.5 < max(turned) < 1.1
    driven = rig.robot.odometer.trip[0]
    client.send('goto West')
    client.until('Arrived')
    assert rig.robot.odometer.trip[0] == driven, 'the robot was already near enough'


def test_a_robot_kept_from_its_last_turn_has_not_arrived() -> None:
    rig = Rig(start=(-3000.0, 2200.0, 0.0))
    client = rig.client()
    client.send('gotoPoint 0 2000 180')
    while not (isinstance(rig.robot.base.manoeuvre, Turn)
               and rig.robot.true_pose.distance_to(0.0, 2000.0) < 1.0):
        rig.clock.advance(rig.clock.now + STEP)
    rig.robot.navigation.blocks.append(Disc(650.0, 2000.0, 250.0))
    rig.clock.advance(rig.clock.now + 10.0)
    assert client.lines() == ['Going to point'] and rig.robot.base.still
    rig.robot.navigation.blocks.clear()
    assert client.until('Arrived') == ['Arrived at point']
    assert abs(normalise(rig.robot.true_pose.theta - 180.0)) < 0.1
