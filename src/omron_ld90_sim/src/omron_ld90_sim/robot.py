"""The robot: one body on one floor, doing one activity at a time.

What it does is written as generators (`activities`): each yields a number of seconds to wait or
`STANDING` to wait until the base stands. The robot runs at most one of them, says `Interrupted:`
for one that another replaces, and tells everybody what happens through `announce`.
"""
from __future__ import annotations

import random
from collections import deque
from dataclasses import dataclass, replace
from enum import Enum
from typing import (
    Callable,
    Deque,
    Dict,
    Generator,
    Iterator,
    List,
    Optional,
    Sequence,
    Set,
    Tuple,
    Union,
)

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
START_DISTANCE = 1000.0     # mm between the start places of two robots
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
    drives: bool = True


@dataclass(frozen=True)
class ApplicationFault:
    """A fault that an application has raised; as text, the fields of a `Fault:` line."""

    name: str
    short: str
    long: str
    driving: bool
    critical: bool

    def __str__(self) -> str:
        kind = ('Fault' + ('_Driving' if self.driving else '')
                + ('_Critical' if self.critical else '') + '_Application')
        flags = ' '.join('true' if flag else 'false'
                         for flag in (self.driving, self.critical, True))
        return f'{kind} {self.name} "{self.short}" "{self.long}" {flags}'


@dataclass
class AnalogInput:
    """An analog input: range in volts, counts at full scale, present voltage."""

    least: float = 0.0
    most: float = 10.0
    most_raw: int = 4095
    voltage: float = 0.0

    @property
    def raw(self) -> int:
        """The voltage in counts."""
        return round((self.voltage - self.least) / (self.most - self.least) * self.most_raw)


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
        self.neighbours: Sequence[Robot] = ()
        self.block_reasons: Dict[str, str] = {}
        self.failing_goals: Set[str] = set()    # names in lower case
        self.last_goal = ''
        self.waiting = ''                       # what a running wait task says
        self.pausing = False                    # whether a pause task runs
        self.patrol_places: Dict[str, int] = {}     # route in lower case -> index it is at
        self.speed_limit: Optional[float] = None    # mm/s, for the present activity
        self.application_faults: Dict[str, ApplicationFault] = {}
        self.inputs = {f'Input_{n}': False for n in range(1, 5)}
        self.outputs = {f'Output_{n}': False for n in range(1, 5)}
        self.analog_inputs = {'Analog_1': AnalogInput(voltage=2.5)}
        self.infos: Dict[str, Tuple[int, str]] = {}     # name -> longest value, value
        self._scans: Deque[Tuple[float, np.ndarray]] = deque()
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
        """Stands at `start`, or in the dock, or where robots start on a map without one."""
        if start is None:
            start = start_places(self.document, self.floor, [None])[0]
        self.base.pose = start
        for dock in self.document.docks:
            inside = docked_pose(self.floor, dock)
            if (start.distance_to(inside.x, inside.y) < 1.0
                    and abs(normalise(start.theta - inside.theta)) < 1.0):
                self.battery.docked(charged_before=True)
                self.docking, self.charge = DockingState.DOCKED, self.battery.charge_state
                self.status, self.extended = self.docking_line, 'Docked'

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

    def dynamic_obstacles(self) -> List[Disc]:
        """Everything in the way that is not on the map.

        A moving neighbour counts where it is, where it could come to rest, and between.
        """
        radius = self.floor.body.half_diagonal
        discs = list(self.obstacles.values())
        for other in self.neighbours:
            places, track = [other.true_pose], other.base.track
            if track is not None:
                here, rest = other.base.place, other.base.stopping_distance()
                places += [track.pose_at(here + rest / 2), track.pose_at(here + rest)]
            discs += [Disc(place.x, place.y, radius) for place in places]
        return discs

    def scan(self) -> np.ndarray:
        """One laser scan: hits (N, 2) in mm, in the frame the robot believes in."""
        others = [other.floor.body.corners(other.true_pose) for other in self.neighbours]
        for disc in self.obstacles.values():
            angles = np.radians(np.arange(0, 360, 30))
            others.append(np.array([disc.x, disc.y]) + disc.radius * np.column_stack(
                [np.cos(angles), np.sin(angles)]))
        ranges = laser.scan(self.floor, self.true_pose, others)
        ranges = ranges + self.noise.normal(0.0, laser.NOISE, len(ranges))
        hits = laser.points(self.pose, ranges)
        self._scans.append((self.clock.now, hits))
        while self._scans[0][0] < self.clock.now - laser.KEPT_FOR:
            self._scans.popleft()
        return hits

    def cumulative_points(self) -> List[int]:
        """x y x y ... (mm) of what the laser has seen lately near by."""
        self.scan()
        seen = np.concatenate([hits for _, hits in self._scans])
        near = np.hypot(*(seen - [self.pose.x, self.pose.y]).T) <= laser.KEPT_WITHIN
        return seen[near][-laser.KEPT_POINTS:].round().astype(int).ravel().tolist()

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

    def start(self, activity: Activity) -> None:
        """Replaces what runs. The base brakes, unless the new activity sets a course at once."""
        self._interrupt()
        self.base.brake()
        self._keep_stepping()
        self._then = None
        self.speed_limit = None
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
        if self.docking is DockingState.DOCKING:
            self.set_docking(DockingState.UNDOCKED, ChargeState.NOT)

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

    def halt(self) -> None:
        """Ends what runs without a word."""
        self._drop_activity()
        self._then = None
        self.base.brake()
        self._keep_stepping()
        self.status = self.extended = 'Stopped'

    def block(self, name: str, text: str = '') -> None:
        """Something forbids driving from now on; what drives is cancelled."""
        self.block_reasons[name] = text
        if self.activity is not None and self.activity.drives:
            self.stop()

    def press_estop(self) -> None:
        """The emergency stop button: motors off, whatever runs has ended."""
        self.cut_motors(Motors.ESTOP)

    def cut_motors(self, motors: Motors) -> None:
        """Motors off: whatever runs has ended, nothing goes on by itself."""
        self._drop_activity()
        self._then = None
        self.base.brake(self.base.limits.emergency_deceleration)
        self._keep_stepping()
        self._set_motors(motors)

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
        """Sends the base to a place, out of standing or of driving forwards; raises `NoWay`."""
        obstacles = self.dynamic_obstacles()
        base, limits, track = self.base, self.base.limits, self.base.track
        if self.speed_limit is not None:
            limits = replace(limits, speed=min(limits.speed, self.speed_limit))
        if track is None or base.speed == 0.0:
            way = self.planner.plan(base.pose, x, y, heading, obstacles)
            base.follow(manoeuvres(way, self.planner, limits))
        else:
            join = self._join(track)
            way = self.planner.plan(track.pose_at(join), x, y, heading, obstacles)
            lead_in = track.cut(base.place, join)
            base.follow(manoeuvres(way, self.planner, limits, lead_in, base.speed))
        self._keep_stepping()

    @property
    def can_set_course(self) -> bool:
        """Standing or driving forwards: not while turning on the spot or backing up."""
        track = self.base.track
        return self.base.still or track is not None and not track.reverse

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


def docked_pose(floor: Floor, dock: MapObject) -> Pose:
    """Where a robot stands when it charges at `dock`: as far in as there is room, up to 250 mm."""
    pose = Pose(dock.x, dock.y, dock.theta)
    steps = np.arange(0.0, DRIVE_IN + 1.0, 10.0)
    fronts = [pose.ahead(step + floor.body.half_length) for step in steps]
    blocked = np.flatnonzero(floor.clearance_at(np.array([[f.x, f.y] for f in fronts])) < 20.0)
    last = int(blocked[0]) - 1 if len(blocked) else len(steps) - 1
    return pose.ahead(float(steps[max(last, 0)]))


def start_places(document: MapDocument, floor: Floor,
                 wanted: Sequence[Optional[Tuple[float, float, float]]], seed: int = 0
                 ) -> List[Pose]:
    """Where robots start: as wanted (mm, mm, degrees), the others one after another.

    In the docks, at RobotHome, at goals with heading, at other goals, and then at random free
    places, each robot clear of the ones before it.
    """
    chance = random.Random(seed)
    taken = [Pose(*place) for place in wanted if place is not None]
    free = (pose for pose in _candidates(document, floor, chance)
            if all(pose.distance_to(t.x, t.y) > START_DISTANCE for t in taken))
    places = []
    for place in wanted:
        if place is None:
            pose = next(free, None)
            if pose is None:
                raise NoWay('the map has no free place where a robot could stand')
            taken.append(pose)
        else:
            pose = Pose(*place)
        places.append(pose)
    return places


def _candidates(document: MapDocument, floor: Floor, chance: random.Random) -> Iterator[Pose]:
    for dock in document.docks:
        yield docked_pose(floor, dock)
    for home in document.homes:
        if home.extent is None:
            yield Pose(home.x, home.y, home.theta)
        else:
            yield Pose(home.rectangle.centre_x, home.rectangle.centre_y, home.theta)
    for goal in sorted(document.goals, key=lambda goal: not goal.has_heading):
        yield Pose(goal.x, goal.y, goal.theta if goal.has_heading else 0.0)
    sizes = np.bincount(floor.regions.ravel())
    sizes[0] = 0
    if sizes.any():
        cells = np.argwhere(floor.regions == sizes.argmax())
        for _ in range(10 * len(cells)):
            x, y = floor.planning_points(cells[[chance.randrange(len(cells))]])[0]
            yield Pose(float(x), float(y), 0.0)
