"""The activities of the robot, as scripts for `SimRobot.start`."""
from __future__ import annotations

from typing import Callable, Optional, Sequence, Tuple

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.behaviour.states import (
    STANDING,
    ActivityFailure,
    DockingPhase,
    Script,
    ScriptedActivity,
)
from omron_ld90_sim.devices.battery import ChargeState
from omron_ld90_sim.motion.kinematics import SimPose, normalise
from omron_ld90_sim.motion.places import docked_pose
from omron_ld90_sim.motion.planner import Blocked, NoWay
from omron_ld90_sim.motion.track import straight_track
from omron_map import MapObject

BLOCKED_TIMEOUT = 30.0      # s of waiting at a blocked path, after which a drive fails
RETRY = 2.0                 # s between two attempts to find a path
PROGRESS = 1000.0           # mm of progress after which the timeout begins again
ARRIVED_WITHIN = 1.0        # a place (mm) or heading (deg) counts as reached within this distance
SETTLE = 0.5                # s between two docking states
AFTER_UNDOCKING = 0.2       # s between `Undocked`, `Stopping` and `Stopped`
_WAVERING_ON_GOTO = (ChargeState.NOT, ChargeState.OVERCHARGE, ChargeState.BULK)
_WAVERING_ON_UNDOCK = (ChargeState.NOT, ChargeState.OVERCHARGE, ChargeState.NOT, ChargeState.BULK,
                       ChargeState.NOT)


def go_to_goal(robot: SimRobot, goal: MapObject,
               heading: Optional[float] = None) -> ScriptedActivity:
    """Carries out `goto`: leaves the dock first, drives to the goal, and turns there if the goal
    has a heading.
    """
    return _go(robot, goal.name, *_place(goal, heading), goal=True)


def go_to_point(robot: SimRobot, x: float, y: float, heading: Optional[float]) -> ScriptedActivity:
    """Carries out `gotoPoint`."""
    return _go(robot, 'point', x, y, heading)


def _go(robot: SimRobot, name: str, x: float, y: float, heading: Optional[float],
        goal: bool = False) -> ScriptedActivity:
    def script() -> Script:
        yield from leave_dock(robot)
        robot.status = robot.extended = f'Going to {name}'
        robot.announce(f'Going to {name}')
        yield from _reach(robot, name, x, y, heading)
        robot.status = robot.extended = f'Arrived at {name}'
        robot.announce(f'Arrived at {name}')

    return ScriptedActivity(f'Going to {name}', f'Going to {name}', script(), (x, y), goal)


def park(robot: SimRobot, goal: MapObject) -> ScriptedActivity:
    """Drives to a goal by the robot's own decision, and stays there."""
    def script() -> Script:
        yield from leave_dock(robot)
        robot.announce('Parking')
        yield from _reach(robot, goal.name, *_place(goal))
        robot.status = robot.extended = 'Parked'
        robot.announce('Parked')

    return ScriptedActivity('Parking', 'Parking', script())


def pass_goal(robot: SimRobot, goal: MapObject) -> Script:
    """Drives to an intermediate goal; only the extended status shows this drive."""
    robot.extended = f'Going to {goal.name}'
    yield from _reach(robot, goal.name, *_place(goal))


def _place(goal: MapObject, heading: Optional[float] = None
           ) -> Tuple[float, float, Optional[float]]:
    if heading is None and goal.has_heading:
        heading = goal.theta
    return goal.x, goal.y, heading


def _reach(robot: SimRobot, name: str, x: float, y: float, heading: Optional[float]) -> Script:
    failed = f'Failed going to {name}'
    robot.tasks.last_goal = name
    if name.lower() in robot.quirks.failing_goals:
        yield 1.0
        raise ActivityFailure('Failed going to goal', failed)
    yield from drive(robot, *_near(robot, x, y, heading), failed)


def _near(robot: SimRobot, x: float, y: float, heading: Optional[float]
          ) -> Tuple[float, float, Optional[float]]:
    """Returns the pose at which the robot stops on a drive to a goal. If there is room, the pose
    has an arrival error.
    """
    distance, angle = robot.quirks.arrival_error
    place = SimPose(x, y, robot.random.uniform(-180.0, 180.0)).ahead(
        robot.random.uniform(0.0, distance))
    turned = robot.random.uniform(-angle, angle)
    if robot.base.still and robot.true_pose.distance_to(x, y) <= distance:
        place = robot.true_pose     # already near enough
    clearance = robot.navigation.floor.clearance_of(place.x, place.y)
    if clearance < robot.navigation.planner.turn_clearance:
        return x, y, heading
    return place.x, place.y, heading if heading is None else normalise(heading + turned)


def drive(robot: SimRobot, x: float, y: float, heading: Optional[float], failed: str) -> Script:
    """Drives to a place, around obstacles."""
    yield from _until_there(robot, x, y, heading,
                            lambda: robot.executive.set_course(x, y, heading), failed)


def _until_there(robot: SimRobot, x: float, y: float, heading: Optional[float],
                 set_off: Callable[[], None], failed: str) -> Script:
    """Starts the drive again until the robot is at a place. Fails if obstacles block the robot for
    BLOCKED_TIMEOUT.
    """
    waited, nearest = 0.0, robot.true_pose.distance_to(x, y)
    while True:
        if not robot.navigation.can_set_course:
            yield from come_to_rest(robot)
        try:
            set_off()
        except Blocked:
            pass
        except NoWay as reason:
            raise ActivityFailure('Failed going to goal', failed) from reason
        else:
            yield STANDING
            left = robot.true_pose.distance_to(x, y)
            turn = 0.0 if heading is None else normalise(robot.true_pose.theta - heading)
            if left < ARRIVED_WITHIN and abs(turn) < ARRIVED_WITHIN:
                return
            if left < nearest - PROGRESS:
                waited, nearest = 0.0, left
        if waited >= BLOCKED_TIMEOUT:
            raise ActivityFailure('Failed going to goal', failed)
        pause = robot.random.uniform(0.5, 1.5) * RETRY      # random: robots do not retry together
        yield pause
        waited += pause


def _straight_to(robot: SimRobot, x: float, y: float) -> None:
    """Begins a slow drive to a place that is straight ahead or behind."""
    here, limits = robot.true_pose, robot.base.limits
    distance = here.distance_to(x, y)
    if here.ahead(distance).distance_to(x, y) > distance:
        distance = -distance
    if abs(distance) >= ARRIVED_WITHIN:
        robot.executive.follow([straight_track(here, distance, limits, limits.docking_speed)])


def come_to_rest(robot: SimRobot) -> Script:
    """Brakes and waits until the robot stands."""
    if not robot.base.still:
        robot.base.brake()
        yield STANDING


def leave_dock(robot: SimRobot, wavering: Sequence[ChargeState] = _WAVERING_ON_GOTO) -> Script:
    """Backs out of the dock if the robot is in it.

    wavering -- the charge states that the robot announces on its way out, as real robots do
    """
    if robot.docking.state is DockingPhase.UNDOCKED:
        return
    yield from come_to_rest(robot)
    robot.docking.update()
    robot.docking.enter(DockingPhase.UNDOCKING, robot.docking.charge)
    robot.extended = 'Undocking'
    dock = nearest_dock(robot)
    if dock is not None:
        _straight_to(robot, dock.x, dock.y)
    for charge in wavering:
        yield SETTLE
        robot.docking.enter(DockingPhase.UNDOCKING, charge)
    yield STANDING
    if dock is not None:
        yield from _until_there(robot, dock.x, dock.y, None,
                                lambda: _straight_to(robot, dock.x, dock.y), 'Failed to undock')
    robot.docking.enter(DockingPhase.UNDOCKED, ChargeState.NOT)


def dock(robot: SimRobot, station: MapObject) -> ScriptedActivity:
    """Carries out `dock`: drives to the dock's pose, then into the station, and charges.

    If the robot misses the charger, it backs out and tries again. All attempts are one `dock`, with
    the states Undocking and Undocked between them (ARCL manual I617-E-02 p. 71).
    """
    failed = f'Failed going to dock at {station.name}'

    def straight_to(x: float, y: float) -> Script:
        yield from _until_there(robot, x, y, None, lambda: _straight_to(robot, x, y), failed)

    def drive_in() -> Script:
        robot.docking.enter(DockingPhase.UNDOCKED, ChargeState.NOT)
        robot.docking.enter(DockingPhase.DOCKING, ChargeState.NOT)
        yield from drive(robot, station.x, station.y, station.theta, failed)
        robot.extended = 'Driving into dock'
        inside = docked_pose(robot.navigation.floor, station)
        yield from straight_to(inside.x, inside.y)

    def script() -> Script:
        yield from drive_in()
        while robot.quirks.failing_docks > 0:
            robot.quirks.failing_docks -= 1
            robot.docking.enter(DockingPhase.UNDOCKING, ChargeState.NOT)
            yield from straight_to(station.x, station.y)
            yield from drive_in()
        robot.docking.enter(DockingPhase.DOCKING, ChargeState.BULK)
        yield SETTLE
        robot.docking.update()
        robot.docking.battery.docked()
        robot.docking.enter(DockingPhase.DOCKED, ChargeState.BULK)
        robot.extended = 'Docked'

    return ScriptedActivity(f'Going to dock at {station.name}', f'Going to dock at {station.name}',
                            script())


def undock(robot: SimRobot) -> ScriptedActivity:
    """Carries out `undock`: backs out.

    A robot that is not docked only sends the three lines that end each undocking: its docking
    state, `Stopping` and `Stopped`.
    """
    def script() -> Script:
        if robot.docking.state is DockingPhase.UNDOCKED:
            robot.announce(robot.docking.line)
        else:
            yield from leave_dock(robot, _WAVERING_ON_UNDOCK)
        yield AFTER_UNDOCKING
        robot.announce_stopping(at_least=AFTER_UNDOCKING)

    return ScriptedActivity('Undocking', 'Undocking', script())


def nearest_dock(robot: SimRobot) -> Optional[MapObject]:
    """Returns the dock nearest to the robot; None if the map has none."""
    pose, docks = robot.true_pose, robot.document.docks
    return min(docks, key=lambda d: pose.distance_to(d.x, d.y)) if docks else None
