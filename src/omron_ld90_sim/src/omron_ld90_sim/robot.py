"""The robot: one body on one floor, doing one activity at a time.

What it does is written as generators (`activities`): each yields a number of seconds to wait or
`STANDING` to wait until the base stands. The robot runs at most one of them, says `Interrupted:`
for one that another replaces, and tells everybody what happens through `announce`.
"""
from __future__ import annotations

import random
from dataclasses import dataclass
from enum import Enum
from typing import Callable, Dict, Generator, List, Optional, Tuple, Union

import numpy as np

from omron_ld90.maps import MapDocument, MapObject
from omron_ld90_sim import laser
from omron_ld90_sim.battery import Battery, ChargeState
from omron_ld90_sim.clock import Clock, Timer
from omron_ld90_sim.floor import Floor
from omron_ld90_sim.kinematics import Pose, normalise
from omron_ld90_sim.motion import STEP, Base
from omron_ld90_sim.planner import Disc, NoWay, Planner
from omron_ld90_sim.track import Track, manoeuvres

DRIVE_IN = 250.0            # mm from the dock's pose to where the robot charges
LOOK_AHEAD = 600.0          # mm beyond the stopping distance that must be free of obstacles
CHARGE_CHECK = 1.0          # s between looks at the charger's phase
TEMPERATURE = 36            # deg C
LOCALIZED_WITHIN = (1000.0, 30.0)   # mm, deg: how far off a localization may start and still find


class DockingState(Enum):
    """The DockingState field of a DockingState line."""

    UNDOCKED = 'Undocked'
    DOCKING = 'Docking'
    DOCKED = 'Docked'
    UNDOCKING = 'Undocking'


class Motors(Enum):
    """Whether the robot can drive, in the words of `queryMotors`."""

    ENABLED = 'Motors enabled'
    DISABLED = 'Motors disabled'
    ESTOP = 'EStop pressed'
    RELIEVED = 'EStop relieved but motors still disabled'


class Failure(Exception):
    """An activity cannot go on: the `Error:` text, and the status that remains."""

    def __init__(self, text: str, status: str) -> None:
        super().__init__(text)
        self.status = status


class _Standing:
    """What an activity yields to wait until the base stands."""


STANDING = _Standing()
Script = Generator[Union[float, _Standing], None, None]


@dataclass
class Activity:
    """Something the robot is doing."""

    status: str         # the Status text while it runs, and the text behind `Interrupted:`
    extended: str
    script: Script


@dataclass(frozen=True)
class Odometer:
    """Readings of the base and the clock at the last reset."""

    driven: float = 0.0
    turned: float = 0.0
    time: float = 0.0


class Robot:
    """One simulated LD-90 without its interface; lengths in mm, angles in degrees."""

    def __init__(self, clock: Clock, document: MapDocument, floor: Floor, start: Optional[Pose],
                 seed: int = 0, battery: float = 100.0,
                 announce: Callable[[str], None] = lambda line: None) -> None:
        self.clock, self.announce = clock, announce
        self.random = random.Random(seed)
        self.noise = np.random.RandomState(seed)
        self.battery = Battery(battery)
        self.motors = Motors.ENABLED
        self.docking = DockingState.UNDOCKED
        self.charge = ChargeState.NOT
        self.activity: Optional[Activity] = None
        self.status = self.extended = 'Stopped'
        self.obstacles: Dict[str, Disc] = {}
        self.neighbours: Callable[[], List[Robot]] = list
        self.block_reasons: Dict[str, str] = {}
        self._error = Pose(0.0, 0.0, 0.0)       # believed minus true
        self._odometer = Odometer()
        self._step_timer: Optional[Timer] = None
        self._wait_timer: Optional[Timer] = None
        self._waits_for_base = False
        self._then: Optional[Callable[[], None]] = None
        self._battery_time = clock.now
        self.load_map(document, floor)
        self.base = Base(Pose(0.0, 0.0, 0.0))
        self._place(start)

    # -- the world ---------------------------------------------------------------------------

    def load_map(self, document: MapDocument, floor: Floor) -> None:
        """Takes over another map; the robot stays where it is."""
        self.document, self.floor, self.planner = document, floor, Planner(floor)

    def _place(self, start: Optional[Pose]) -> None:
        dock = self.document.docks[0] if self.document.docks else None
        if start is None and dock is not None:
            self.base.pose = self.docked_pose(dock)
            self.battery.docked(full_charge_known=True)
            self.docking, self.charge = DockingState.DOCKED, self.battery.charge_state
            self.status, self.extended = self.docking_line, 'Docked'
        else:
            self.base.pose = start or start_without_dock(self.document, self.floor, self.random)

    @property
    def true_pose(self) -> Pose:
        """Where the body is."""
        return self.base.pose

    @property
    def pose(self) -> Pose:
        """Where the robot believes to be, as it reports."""
        true, error = self.base.pose, self._error
        return Pose(true.x + error.x, true.y + error.y, normalise(true.theta + error.theta))

    @property
    def lost(self) -> bool:
        """Whether the robot's belief of its place is wrong."""
        return self._error != Pose(0.0, 0.0, 0.0)

    def docked_pose(self, dock: MapObject) -> Pose:
        """Where the robot stands when it charges at `dock`."""
        pose = Pose(dock.x, dock.y, dock.theta)
        steps = np.arange(0.0, DRIVE_IN + 1.0, 10.0)
        fitting = 0.0
        for step in steps:
            ahead = pose.ahead(step + self.floor.body.half_length)
            if self.floor.clearance_of(ahead.x, ahead.y) < 20.0:
                break
            fitting = float(step)
        return pose.ahead(fitting)

    def dynamic_obstacles(self) -> List[Disc]:
        """Everything in the way that is not on the map."""
        radius = self.floor.body.half_diagonal
        return [*self.obstacles.values(), *(Disc(other.true_pose.x, other.true_pose.y, radius)
                                            for other in self.neighbours())]

    def scan(self) -> np.ndarray:
        """One laser scan: hits (N, 2) in mm, in the frame the robot believes in."""
        others = [other.floor.body.corners(other.true_pose) for other in self.neighbours()]
        for disc in self.obstacles.values():
            angles = np.radians(np.arange(0, 360, 30))
            others.append(np.array([disc.x, disc.y]) + disc.radius * np.column_stack(
                [np.cos(angles), np.sin(angles)]))
        ranges = laser.scan(self.floor, self.true_pose, others)
        ranges = ranges + self.noise.normal(0.0, laser.NOISE, len(ranges))
        return laser.points(self.pose, ranges)

    # -- what it says ------------------------------------------------------------------------

    @property
    def docking_line(self) -> str:
        """The DockingState line."""
        return (f'DockingState: {self.docking.value} ForcedState: Unforced '
                f'ChargeState: {self.charge.value}')

    def set_docking(self, docking: DockingState, charge: ChargeState) -> None:
        """Changes and announces the docking state."""
        self.docking, self.charge = docking, charge
        if docking is not DockingState.UNDOCKED:
            self.status = self.docking_line
        self.announce(self.docking_line)
        if docking is DockingState.DOCKED:
            self._watch_charge()

    def _watch_charge(self) -> None:
        """Follows the charger's phases until the battery is full."""
        if self.docking is DockingState.DOCKED and self.charge is not ChargeState.FLOAT:
            self.clock.after(CHARGE_CHECK, self.update_battery)
            self.clock.after(CHARGE_CHECK, self._watch_charge)

    @property
    def localization_score(self) -> float:
        """How well the laser fits the map at the believed pose, 0 to 1."""
        fit = 0.06 if self.lost else 0.87
        return min(max(fit + self.random.gauss(0.0, 0.012), 0.0), 1.0)

    @property
    def odometer(self) -> Tuple[float, float, float]:
        """Millimetres, degrees and seconds since the last reset."""
        zero = self._odometer
        return (self.base.driven - zero.driven, self.base.turned - zero.turned,
                self.clock.now - zero.time)

    def reset_odometer(self) -> None:
        """Starts the odometer from zero."""
        self._odometer = Odometer(self.base.driven, self.base.turned, self.clock.now)

    @property
    def state_of_charge(self) -> float:
        """Percent, now."""
        self.update_battery()
        return self.battery.percent

    def update_battery(self) -> None:
        """Brings the battery up to now and announces a new charge phase."""
        elapsed, self._battery_time = self.clock.now - self._battery_time, self.clock.now
        if self.docking is DockingState.DOCKED:
            self.battery.charge(elapsed)
            if self.battery.charge_state is not self.charge:
                self.set_docking(DockingState.DOCKED, self.battery.charge_state)
        else:
            self.battery.discharge(elapsed, not self.base.still)

    # -- activities --------------------------------------------------------------------------

    @property
    def can_drive(self) -> bool:
        """Motors on, localized and not blocked by an application."""
        return self.motors is Motors.ENABLED and not self.lost and not self.block_reasons

    def start(self, activity: Activity, keep_moving: bool = False) -> None:
        """Replaces what runs; `keep_moving` when the new one drives on without stopping."""
        self._interrupt()
        if not keep_moving:
            self.base.brake()
            self._keep_stepping()
        self._then = None
        self.activity = activity
        self.status, self.extended = activity.status, activity.extended
        self._resume()

    def _interrupt(self) -> None:
        if self.activity is not None:
            text = self.activity.status
            self._drop_activity()
            self.announce(f'Interrupted: {text}')

    def _drop_activity(self) -> None:
        if self.activity is not None:
            self.activity.script.close()
        self.activity, self._waits_for_base = None, False
        if self._wait_timer is not None:
            self._wait_timer.cancel()

    def _resume(self) -> None:
        activity = self.activity
        if activity is None:
            return
        try:
            request = next(activity.script)
        except StopIteration:
            if self.activity is activity:
                self.activity = None
            return
        except Failure as failure:
            if self.activity is activity:
                self.activity = None
            self.status = self.extended = failure.status
            self.announce(f'Error: {failure}')
            self.base.brake()
            self._keep_stepping()
            return
        if request is STANDING:
            self._waits_for_base = True
            self._keep_stepping()
        else:
            self._wait_timer = self.clock.after(float(request), self._resume)

    def stop(self) -> None:
        """Ends what runs, with the robot's words for it."""
        self._interrupt()
        self.announce_stopping()

    def announce_stopping(self) -> None:
        """Brakes: `Stopping`, and `Stopped` when the robot stands."""
        self.status = self.extended = 'Stopping'
        self.announce('Stopping')
        self.base.brake()

        def stopped() -> None:
            self.status = self.extended = 'Stopped'
            self.announce('Stopped')

        if self.base.still:
            stopped()
        else:
            self._then = stopped
            self._keep_stepping()

    def press_estop(self) -> None:
        """The emergency stop button: motors off, whatever runs has ended."""
        self._drop_activity()
        self._then = None
        self.base.brake(self.base.limits.emergency_deceleration)
        self._keep_stepping()
        self._set_motors(Motors.ESTOP)

    def release_estop(self) -> None:
        """The button is pulled; the motors stay off."""
        if self.motors is Motors.ESTOP:
            self._set_motors(Motors.RELIEVED)

    def _set_motors(self, motors: Motors) -> None:
        self.motors = motors
        self.status = self.extended = motors.value
        self.announce(motors.value)

    def enable_motors(self) -> bool:
        """Motors on again; False while the button is pressed."""
        if self.motors is Motors.ESTOP:
            return False
        if self.motors is not Motors.ENABLED:
            self.motors = Motors.ENABLED
            self.announce(Motors.ENABLED.value)
            self.announce_stopping()
        return True

    # -- driving -----------------------------------------------------------------------------

    def set_course(self, x: float, y: float, heading: Optional[float]) -> None:
        """Sends the base to a place, from standing or out of its motion; `NoWay` if there is none.
        """
        obstacles = self.dynamic_obstacles()
        base, limits = self.base, self.base.limits
        track = base.track
        if track is None or base.speed == 0.0 or track.reverse:
            way = self.planner.plan(base.pose, x, y, heading, obstacles)
            self.base.follow(list(manoeuvres(way, self.planner, limits)))
        else:
            join = self._join(track)
            way = self.planner.plan(track.pose_at(join), x, y, heading, obstacles)
            lead_in = track.cut(base.place, join)
            base.follow(manoeuvres(way, self.planner, limits, lead_in, base.speed))
        self._keep_stepping()

    def _join(self, track: Track) -> float:
        """Where on the present track a new one can begin: room to turn, and far enough to brake."""
        first = self.base.place + self.base.stopping_distance() + 300.0
        for s in np.arange(first, track.length, 100.0):
            pose = track.pose_at(s)
            if (track.curvature_at(s) == 0.0 and self.floor.clearance_of(pose.x, pose.y)
                    >= self.planner.turn_clearance):
                return float(s)
        return track.length

    def _keep_stepping(self) -> None:
        if self._step_timer is None or not self._step_timer.waiting:
            self._step_timer = self.clock.after(STEP, self._step)

    def _step(self) -> None:
        self.update_battery()
        self.base.step(STEP)
        if self._blocked_ahead():
            self.base.brake()
        if not self.base.still:
            self._keep_stepping()
            return
        then, self._then = self._then, None
        if then is not None:
            then()
        if self._waits_for_base:
            self._waits_for_base = False
            self._resume()

    def _blocked_ahead(self) -> bool:
        track, obstacles = self.base.track, self.dynamic_obstacles()
        if not obstacles or track is None or self.base.braking:
            return False
        reach = self.base.stopping_distance() + LOOK_AHEAD
        places = np.arange(self.base.place, min(self.base.place + reach, track.length), 100.0)
        ahead = [track.pose_at(s) for s in places]
        clear = self.floor.body.half_width
        return any(pose.distance_to(disc.x, disc.y) < disc.radius + clear
                   for pose in ahead for disc in obstacles)

    # -- localization ------------------------------------------------------------------------

    def localize(self, pose: Pose, spread: Tuple[float, float] = LOCALIZED_WITHIN) -> None:
        """Looks for itself around `pose`; lost when it is not there."""
        true = self.base.pose
        off = true.distance_to(pose.x, pose.y)
        turned = abs(normalise(pose.theta - true.theta))
        if off <= spread[0] and turned <= spread[1]:
            self._error = Pose(0.0, 0.0, 0.0)
            if self.status == 'Robot lost':
                self.status = self.extended = 'Stopped'
        else:
            self.lose(Pose(pose.x - true.x, pose.y - true.y, normalise(pose.theta - true.theta)))

    def lose(self, error: Pose) -> None:
        """Believes from now on in a pose that is off by `error`; what runs ends."""
        self._error = error
        if self.activity is not None:
            self._drop_activity()
            self.base.brake()
            self._keep_stepping()
            self.announce('Error: Robot lost')
        self.status = self.extended = 'Robot lost'


def start_without_dock(document: MapDocument, floor: Floor, chance: random.Random) -> Pose:
    """Where a robot starts on a map without a dock: home, a goal, or a free place."""
    homes, goals = list(document.homes), list(document.goals)
    for candidate in (*homes[:1], *[g for g in goals if g.has_heading][:1], *goals[:1]):
        if candidate.kind == 'RobotHome' and candidate.extent is not None:
            area = candidate.rectangle
            return Pose(area.centre_x, area.centre_y, candidate.theta)
        return Pose(candidate.x, candidate.y, candidate.theta if candidate.has_heading else 0.0)
    sizes = np.bincount(floor.regions.ravel())
    sizes[0] = 0
    if not sizes.any():
        raise NoWay('the map has no place where the robot could stand')
    cells = np.argwhere(floor.regions == sizes.argmax())
    x, y = floor.planning_points(cells[[chance.randrange(len(cells))]])[0]
    return Pose(float(x), float(y), 0.0)
