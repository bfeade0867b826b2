"""Goals that change during the drive, and robots that meet."""
from __future__ import annotations

import math
from pathlib import Path
from typing import Optional

import numpy as np
import pytest
from motion_inspector import Inspector
from proofs import is_whole
from sim_builders import LAB, Obstacles, Rig, corridor, fleet, gap, room

from omron_ld90_sim.motion.base import STEP
from omron_map import MapDocument

CHANGES = 150 if is_whole(__file__) else 50  # number of changes of the goal during a drive


def test_a_new_goal_straight_ahead_is_taken_without_slowing_down() -> None:
    rig = Rig(start=(-3000.0, 2200.0, 0.0))
    client = rig.client()
    client.send('gotoPoint 0 2200')
    while rig.robot.base.speed < 600.0:
        rig.clock.advance(rig.clock.now + STEP)
    client.send('gotoPoint 5000 2200')
    slowest = math.inf
    while rig.robot.true_pose.x < 0.0:
        rig.clock.advance(rig.clock.now + STEP)
        slowest = min(slowest, rig.robot.base.speed)
    assert slowest >= 600.0


def test_a_new_goal_behind_is_taken_within_the_limits() -> None:
    rig = Rig(start=(-3000.0, 2200.0, 0.0))
    client = rig.client()
    client.send('gotoPoint 5000 2200')
    rig.clock.advance(4.0)
    client.send('gotoPoint -3000 2200')
    client.lines()
    speed = rig.robot.base.speed
    while not rig.robot.base.still:
        rig.clock.advance(rig.clock.now + STEP)
        now = rig.robot.base.speed
        assert abs(now - speed) <= 500.0 * STEP + 1e-6
        speed = now
    assert rig.robot.true_pose.distance_to(-3000.0, 2200.0) < 1.0


@pytest.mark.parametrize('path', [None, LAB], ids=['room', 'lab'])
def test_goals_that_change_on_the_way_never_break_a_limit(path: Optional[Path]) -> None:
    document = MapDocument.load(str(path)) if path else room()
    first = document.goals[0]
    rig = Rig(document, start=(first.x, first.y, 0.0), seed=3)
    inspector = Inspector(Obstacles(document), rig.robot.base)
    client, random = rig.client(), np.random.RandomState(4)
    for _ in range(CHANGES):
        goal = document.goals[random.randint(len(document.goals))]
        words = ['stop', f'goto {goal.name}', f'gotoPoint {goal.x} {goal.y} {random.randint(360)}']
        client.send(words[random.choice(3, p=[0.1, 0.6, 0.3])].replace('East side', '"East side"'))
        rig.clock.advance(rig.clock.now + random.uniform(0.1, 8.0))
    lines = client.lines()
    assert not [line for line in lines if line.startswith(('Error', 'CommandError'))]
    inspector.check()
    assert inspector.steps > 33 * CHANGES
    assert sum(line.startswith('Going') for line in lines) > 0.6 * CHANGES


@pytest.mark.parametrize('width', [900.0, 1400.0, 2000.0, 2600.0])
def test_two_robots_head_on_in_a_corridor_pass_or_give_up_but_never_touch(width: float) -> None:
    left, right = fleet(corridor(width), (-10000.0, 0.0, 0.0), (10000.0, 0.0, 180.0))
    one, two = left.client(), right.client()
    one.send('gotoPoint 14000 0')
    two.send('gotoPoint -14000 0')
    nearest = math.inf
    while left.robot.activity or right.robot.activity:
        left.clock.advance(left.clock.now + STEP)
        nearest = min(nearest, gap(left.robot.true_pose, right.robot.true_pose))
        assert left.clock.now < 120.0, 'the robots wait for each other for ever'
    assert nearest > 100.0, f'the robots came as near as {nearest:.0f} mm'
    end = 'Arrived at point' if width > 2200.0 else 'Error: Failed going to goal'
    assert one.lines() == two.lines() == ['Going to point', end]


def test_robots_in_a_crowd_never_touch() -> None:
    document = room()
    rigs = fleet(document, (-3000.0, 0.0, 0.0), (-3000.0, 1500.0, 0.0), (4500.0, -2000.0, 90.0))
    clients, random = [rig.client() for rig in rigs], np.random.RandomState(2)
    words = ['goto West', 'goto 12', 'goto "East side"', 'dock', 'stop']
    inspectors = [Inspector(Obstacles(document), rig.robot.base) for rig in rigs]
    nearest = math.inf
    for _ in range(60):
        for client in clients:
            if random.rand() < 0.4:
                client.send(words[random.choice(5, p=[0.25, 0.25, 0.25, 0.15, 0.1])])
        end = rigs[0].clock.now + 5.0
        while rigs[0].clock.now < end:
            rigs[0].clock.advance(rigs[0].clock.now + STEP)
            poses = [rig.robot.true_pose for rig in rigs]
            nearest = min(nearest, *(gap(poses[i], poses[j]) for i, j in ((0, 1), (0, 2), (1, 2))))
    assert nearest > 20.0, f'the robots came as near as {nearest:.0f} mm'
    for inspector in inspectors:
        inspector.check()
    lines = [line for client in clients for line in client.lines()]
    assert sum(line.startswith(('Arrived', 'DockingState: Docked')) for line in lines) > 20
