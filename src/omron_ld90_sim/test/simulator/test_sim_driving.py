"""The robot's motion: it never touches anything and keeps its limits at every step."""
from __future__ import annotations

import math
from pathlib import Path
from typing import Optional, Tuple

import numpy as np
import pytest
from sim_builders import LAB, REAL_MAPS, Obstacles, Rig, corridor, fleet, gap, room
from skimage.measure import label

from omron_ld90_sim.interface.faults import Faults
from omron_ld90_sim.motion.base import STEP, Base
from omron_ld90_sim.motion.floor import Floor
from omron_ld90_sim.motion.kinematics import LD90_BODY, LD90_LIMITS, Pose, normalise
from omron_ld90_sim.motion.manoeuvres import manoeuvres
from omron_ld90_sim.motion.planner import NoWay, Planner
from omron_ld90_sim.motion.space import Disc
from omron_ld90_sim.motion.track import Turn
from omron_map import MapDocument

PAIRS = 200
MAPS = [LAB, REAL_MAPS / 'omron-ld-site-a.map', REAL_MAPS / 'omron-ld-site-b.map']


def random_pairs(floor: Floor, planner: Planner, near: Tuple[float, float], count: int):
    """Random poses with room to turn, in the part of the floor connected with `near`."""
    connected = label(floor.planning_clearance >= planner.drive_clearance, connectivity=1)
    part = connected == connected[floor.planning_cell(*near)]
    cells = np.argwhere(part & (floor.planning_clearance >= planner.turn_clearance))
    assert len(cells) > 100, 'hardly any room around that goal'
    random = np.random.RandomState(5)
    for _ in range(count):
        start, goal = floor.planning_points(cells[random.randint(len(cells), size=2)])
        yield (Pose(start[0], start[1], random.uniform(-180, 180)),
               Pose(goal[0], goal[1], random.uniform(-180, 180)))


class Inspector:
    """Notes every step of a base; `check` holds them all against obstacles and limits."""

    def __init__(self, obstacles: Obstacles, base: Base) -> None:
        # no border of an area is ever touched, so it is enough that the start is outside
        assert not obstacles.forbidden(base.pose)
        self.obstacles, self.base = obstacles, base
        self._rows = [self._row(False)]
        self._step, base.step = base.step, self.step

    def _row(self, turning: bool) -> Tuple[float, ...]:
        pose = self.base.pose
        return pose.x, pose.y, pose.theta, self.base.speed, self.base.rotation, turning

    @property
    def steps(self) -> int:
        """How many steps there were."""
        return len(self._rows) - 1

    def step(self, dt: float = STEP) -> None:
        """Does a step and notes it."""
        turning = isinstance(self.base.manoeuvre, Turn)
        self._step(dt)
        self._rows.append(self._row(turning))

    def drive(self, seconds: float = 1000.0) -> None:
        """Steps the base to its end and checks all steps."""
        while not self.base.still:
            self.base.step()
            assert self.steps * STEP < seconds, 'the robot does not arrive'
        self.check()

    def check(self, hardest_braking: float = LD90_LIMITS.deceleration) -> None:
        """Checks all steps so far."""
        limits, rows = LD90_LIMITS, np.array(self._rows)
        places, speed, turning = rows[1:, :2], rows[:, 3], rows[1:, 5] > 0
        gained = np.diff(speed) / STEP
        spun = np.abs(np.diff(rows[:, 4])) / STEP
        turned = np.abs((np.diff(rows[:, 2]) + 180.0) % 360.0 - 180.0) / STEP
        moved = np.hypot(*np.diff(rows[:, :2], axis=0).T) / STEP
        clear = self.obstacles.clearances(places)
        self._hold(speed[1:] <= limits.speed + 1e-6, 'too fast')
        self._hold(gained >= -hardest_braking - 1e-6, 'braked too hard')
        self._hold(gained <= limits.acceleration + 1e-6, 'accelerated too hard')
        self._hold(spun <= limits.rotation_acceleration + 1e-6, 'began to turn too hard')
        self._hold(turned <= limits.path_rotation + 1e-6, 'turned too fast')
        self._hold(np.abs(moved - (speed[:-1] + speed[1:]) / 2) < 8.0, 'jumped')
        self._hold(clear >= LD90_BODY.half_width, 'too near while driving')
        self._hold(~turning | (clear >= LD90_BODY.half_diagonal), 'too near while turning')
        # farther away than half its diagonal the body can touch nothing
        for number in np.flatnonzero(clear <= LD90_BODY.half_diagonal):
            pose = Pose(*rows[number + 1, :3])
            assert self.obstacles.distance(pose) > 0.0, f'touched at {pose}'

    def _hold(self, held: np.ndarray, fault: str) -> None:
        broken = np.flatnonzero(~held)
        assert not len(broken), f'{fault} at {Pose(*self._rows[broken[0] + 1][:3])}'


@pytest.mark.parametrize('path', MAPS, ids=lambda path: path.stem)
def test_between_random_poses_the_body_touches_nothing(path: Path) -> None:
    if not path.exists():
        pytest.skip(f'{path.name} is not here')
    document = MapDocument.load(str(path))
    floor = Floor.from_map(document)
    planner = Planner(floor)
    obstacles = Obstacles(document)
    first = document.goals[0]
    for start, end in random_pairs(floor, planner, (first.x, first.y), PAIRS):
        way = planner.plan(start, end.x, end.y, end.theta)
        base = Base(start)
        base.follow(manoeuvres(way, planner))
        Inspector(obstacles, base).drive()
        assert base.pose.distance_to(end.x, end.y) < 1.0
        assert abs(normalise(base.pose.theta - end.theta)) < 0.1


def lonely_floor(*walls: Tuple[float, float, float, float]) -> Floor:
    everything = np.array([[-5000, -4000, 5000, -4000], [-5000, 4000, 5000, 4000],
                           [-5000, -4000, -5000, 4000], [5000, -4000, 5000, 4000], *walls], float)
    return Floor(np.empty((0, 2)), everything, np.empty((0, 4)), [], 20, np.empty((0, 2)))


def test_a_door_too_narrow_to_turn_in_is_driven_through_straight() -> None:
    floor = lonely_floor((0, -4000, 0, -330), (0, 330, 0, 4000))
    planner = Planner(floor)
    way = planner.plan(Pose(-3000.0, 2000.0, 0.0), 3000.0, -2000.0)
    base = Base(way.start)
    base.follow(manoeuvres(way, planner))
    while not base.still:
        base.step()
        if abs(base.pose.x) < 400.0:
            corners = LD90_BODY.corners(base.pose)
            assert np.abs(corners[np.abs(corners[:, 0]) < 50.0, 1]).max(initial=0.0) < 330.0
    assert base.pose.distance_to(3000.0, -2000.0) < 1.0


def test_a_door_narrower_than_the_robot_is_no_way() -> None:
    planner = Planner(lonely_floor((0, -4000, 0, -250), (0, 250, 0, 4000)))
    with pytest.raises(NoWay):
        planner.plan(Pose(-3000.0, 2000.0, 0.0), 3000.0, -2000.0)


def test_a_detour_of_many_metres_is_found() -> None:
    outside = np.array([[-20000, -15000, 20000, -15000], [-20000, 15000, 20000, 15000],
                        [-20000, -15000, -20000, 15000], [20000, -15000, 20000, 15000],
                        [0, -15000, 0, 13000]], float)      # a wall with a gap at its far end
    planner = Planner(Floor(np.empty((0, 2)), outside, np.empty((0, 4)), [], 20,
                            np.empty((0, 2))))
    way = planner.plan(Pose(-1000.0, -5000.0, 0.0), 1000.0, -5000.0)
    assert 36_000.0 < way.length < 40_000.0
    near = planner.plan(Pose(-1000.0, -5000.0, 0.0), -4000.0, -5000.0)
    assert near.length < 3_010.0


def test_a_corridor_of_900_mm_with_a_bend_can_be_driven() -> None:
    # an L: along y = 0 from the left, then up along x = 0
    floor = lonely_floor((-5000, 450, -450, 450), (-450, 450, -450, 4000),
                         (-5000, -450, 450, -450), (450, -450, 450, 4000))
    planner = Planner(floor)
    way = planner.plan(Pose(-4000.0, 0.0, 0.0), 0.0, 3500.0)
    base = Base(way.start)
    base.follow(manoeuvres(way, planner))
    while not base.still:
        base.step()
        outline = LD90_BODY.corners(base.pose)
        assert floor.clearance_at(outline).min() > 0.0, f'touched at {base.pose}'
    assert base.pose.distance_to(0.0, 3500.0) < 1.0


def test_out_of_a_niche_the_robot_backs_up_before_it_turns() -> None:
    floor = lonely_floor((2000, -330, 5000, -330), (2000, 330, 5000, 330))
    planner = Planner(floor)
    way = planner.plan(Pose(4000.0, 0.0, 0.0), -3000.0, 0.0)
    assert way.escape < -1500.0


def test_around_an_obstacle_that_is_not_on_the_map() -> None:
    planner = Planner(lonely_floor())
    disc = Disc(0.0, 0.0, 400.0)
    way = planner.plan(Pose(-3000.0, 0.0, 0.0), 3000.0, 0.0, obstacles=[disc])
    base = Base(way.start)
    base.follow(manoeuvres(way, planner))
    nearest = math.inf
    while not base.still:
        base.step()
        nearest = min(nearest, base.pose.distance_to(0.0, 0.0))
    assert 400.0 + LD90_BODY.half_width <= nearest < 1500.0


def test_the_robot_brakes_for_a_goal_from_metres_away() -> None:
    planner = Planner(lonely_floor())
    base = Base(Pose(-4500.0, 0.0, 0.0))
    base.follow(manoeuvres(planner.plan(base.pose, 4500.0, 0.0), planner))
    braking_from = None
    while not base.still:
        before = base.speed
        base.step()
        if braking_from is None and base.speed < before:
            braking_from = 4500.0 - base.pose.x
            fastest = before
    expected = fastest ** 2 / (2 * LD90_LIMITS.goal_deceleration)
    assert braking_from == pytest.approx(expected, abs=100.0)
    assert fastest > 1200.0


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
    for _ in range(150):
        goal = document.goals[random.randint(len(document.goals))]
        words = ['stop', f'goto {goal.name}', f'gotoPoint {goal.x} {goal.y} {random.randint(360)}']
        client.send(words[random.choice(3, p=[0.1, 0.6, 0.3])].replace('East side', '"East side"'))
        rig.clock.advance(rig.clock.now + random.uniform(0.1, 8.0))
    lines = client.lines()
    assert not [line for line in lines if line.startswith(('Error', 'CommandError'))]
    inspector.check()
    assert inspector.steps > 5000 and sum(line.startswith('Going') for line in lines) > 100


@pytest.mark.parametrize('path', [None, *MAPS], ids=lambda path: path.stem if path else 'room')
def test_no_fault_and_no_task_makes_the_robot_break_a_limit(path: Optional[Path]) -> None:
    if path and not path.exists():
        pytest.skip(f'{path.name} is not here')
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
        else:       # on its feet again, with a new client if need be
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
    assert rig.robot.odometer.trip[0] == driven, 'near enough already'


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
        assert left.clock.now < 120.0, 'they wait for each other for ever'
    assert nearest > 100.0, f'they came as near as {nearest:.0f} mm'
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
    assert nearest > 20.0, f'they came as near as {nearest:.0f} mm'
    for inspector in inspectors:
        inspector.check()
    lines = [line for client in clients for line in client.lines()]
    assert sum(line.startswith(('Arrived', 'DockingState: Docked')) for line in lines) > 20


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


def test_an_emergency_stop_brakes_hard_but_turns_no_harder_than_ever() -> None:
    rig = Rig(start=(-3000.0, 2200.0, 0.0))
    client = rig.client()
    client.send('goto 12')      # round the end of the wall
    while abs(rig.robot.base.rotation) < 30.0 or rig.robot.base.speed < 300.0:
        rig.clock.advance(rig.clock.now + STEP)
    start = rig.robot.base.speed
    rig.robot.press_estop()
    client.send('stop')         # must not weaken it
    steps = []
    while not rig.robot.base.still:
        before = rig.robot.base.speed, rig.robot.base.rotation
        rig.clock.advance(rig.clock.now + STEP)
        steps.append((before[0] - rig.robot.base.speed, before[1] - rig.robot.base.rotation))
    braked, spun = np.abs(steps).max(axis=0) / STEP
    assert spun <= LD90_LIMITS.rotation_acceleration + 1e-6
    assert braked <= LD90_LIMITS.emergency_deceleration + 1e-6
    assert len(steps) * STEP < start / LD90_LIMITS.deceleration, 'no faster than any stop'
