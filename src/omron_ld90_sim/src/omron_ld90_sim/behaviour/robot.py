"""The robot: one body on one floor, with one activity at a time.

It sends `Interrupted:` for an activity that another one replaces, keeps what forbids driving, and
announces events to all clients through `announce`. Its `executive` carries out the activities.
"""
from __future__ import annotations

import random
from typing import Callable, Dict, List, Optional, Set, Tuple

import numpy as np

from omron_ld90_sim.behaviour.docking import Docking
from omron_ld90_sim.behaviour.executive import Executive
from omron_ld90_sim.behaviour.state_times import StateTimes, WorkState
from omron_ld90_sim.behaviour.states import (
    Activity,
    DockingState,
    Failure,
    InterruptedWords,
    Motors,
)
from omron_ld90_sim.clock import Clock
from omron_ld90_sim.devices import laser
from omron_ld90_sim.devices.battery import ChargeState
from omron_ld90_sim.devices.equipment import Equipment
from omron_ld90_sim.devices.localization import FOUND_WITHIN, Localization
from omron_ld90_sim.devices.odometer import Odometer
from omron_ld90_sim.devices.scanner import Scanner
from omron_ld90_sim.motion.base import Base
from omron_ld90_sim.motion.floor import Floor
from omron_ld90_sim.motion.kinematics import Pose, normalise
from omron_ld90_sim.motion.navigation import Navigation
from omron_ld90_sim.motion.places import docked_pose, start_places
from omron_ld90_sim.motion.planner import Planner
from omron_ld90_sim.motion.track import Manoeuvre
from omron_map import MapDocument


class Robot:
    """One simulated LD-90 without its interface; lengths in mm, angles in degrees."""

    def __init__(self, clock: Clock, document: MapDocument, floor: Floor, start: Optional[Pose],
                 seed: int = 0, battery: float = 100.0,
                 announce: Callable[[str], None] = lambda line: None,
                 arrival_error: Tuple[float, float] = (0.0, 0.0)) -> None:
        """`arrival_error`: the largest error (mm, deg) with which the robot stops at a goal."""
        self.clock, self.announce = clock, announce
        self.arrival_error = arrival_error
        self.random = random.Random(seed)
        self.scanner = Scanner(clock, seed)
        self.motors = Motors.ENABLED
        self.status = self.extended = 'Stopped'
        self.blocked_by: List[Tuple[str, str]] = []     # what forbids driving: kind and name
        self.failing_goals: Set[str] = set()    # names in lower case
        self.failing_docks = 0                  # number of next drives into a dock that fail
        self.interrupted_words = InterruptedWords.NAME
        self.stops_to_replace = False           # whether it says `Stopping` to replace a drive
        self.speed_limit: Optional[float] = None    # mm/s, of every drive
        self.last_goal = ''
        self.waiting = ''                       # status text of a running wait task
        self.pausing = False                    # whether a pause task runs
        self.patrol_places: Dict[str, int] = {}     # route in lower case -> index of present goal
        self.equipment = Equipment()
        self.localization = Localization(clock, seed)
        self.document = document
        self.base = Base(start or start_places(document, floor, [None])[0])
        self.docking = Docking(clock, self.base, battery, self._docking_changed)
        self.odometer = Odometer(self.base, clock)
        self.state_times = StateTimes(clock, self.base)
        self.navigation = Navigation(self.base, floor)
        self.executive = Executive(clock, self.navigation, self.docking.update, self._failed)
        self._dock_at_start()

    # -- the world ---------------------------------------------------------------------------

    def load_map(self, document: MapDocument, floor: Floor) -> None:
        """Loads another map; the robot stays where it is."""
        self.document = document
        self.navigation.change_floor(floor)

    def _dock_at_start(self) -> None:
        """Sets up a robot that starts in a dock: it is charged, or charges."""
        here = self.base.pose
        for dock in self.document.docks:
            inside = docked_pose(self.floor, dock)
            if (here.distance_to(inside.x, inside.y) < 1.0
                    and abs(normalise(here.theta - inside.theta)) < 1.0):
                self.docking.begin_docked()
                self._note_state()
                self._at_rest()

    @property
    def floor(self) -> Floor:
        """The floor on which the robot drives."""
        return self.navigation.floor

    @property
    def planner(self) -> Planner:
        """The planner of its paths."""
        return self.navigation.planner

    @property
    def true_pose(self) -> Pose:
        """The true pose of the body."""
        return self.base.pose

    @property
    def pose(self) -> Pose:
        """The pose that the robot believes and reports."""
        return self.localization.believed(self.base.pose)

    @property
    def lost(self) -> bool:
        """Whether the believed pose is wrong."""
        return self.localization.lost

    def scan(self) -> np.ndarray:
        """One laser scan: hits (N, 2) in mm, in the frame of the believed pose."""
        return self.scanner.scan(self.floor, self.true_pose, self.pose,
                                 self.navigation.outlines(laser.RANGE))

    def _docking_changed(self) -> None:
        if self.docking.state is not DockingState.UNDOCKED:
            self.status = self.docking.line
        self._note_state()
        self.announce(self.docking.line)

    def _note_state(self) -> None:
        """Updates the state whose times the data store counts."""
        if self.motors in (Motors.ESTOP, Motors.RELIEVED):
            state: Optional[WorkState] = WorkState.IN_ESTOP
        elif any(kind == 'fault' for kind, _ in self.blocked_by):
            state = WorkState.IN_FAULT
        else:
            state = {DockingState.DOCKING: WorkState.DOCKING,
                     DockingState.DOCKED: WorkState.DOCKED}.get(self.docking.state)
        self.state_times.enter(state)

    # -- activities --------------------------------------------------------------------------

    @property
    def activity(self) -> Optional[Activity]:
        """The present activity, if any."""
        return self.executive.activity

    def start(self, activity: Activity) -> None:
        """Replaces the activity. The base brakes, unless the new one sets a course at once."""
        if self._interrupt() and self.stops_to_replace:
            self.announce('Stopping')
        self.navigation.speed_limit = self.speed_limit
        self.status, self.extended = activity.status, activity.extended
        self.executive.run(activity)

    def _interrupt(self) -> bool:
        """Ends the activity; False if there is none."""
        interrupted = self.activity is not None
        if self.activity is not None:
            line = self.activity.interrupted(self.interrupted_words)
            self._drop_activity()
            if line is not None:
                self.announce(line)
        return interrupted

    def _drop_activity(self) -> None:
        self.executive.drop()
        self._give_up_docking()

    def _give_up_docking(self) -> None:
        if self.docking.state in (DockingState.DOCKING, DockingState.UNDOCKING):
            self.docking.enter(DockingState.UNDOCKED, ChargeState.NOT)

    def _failed(self, failure: Failure) -> None:
        self._give_up_docking()
        self.status = self.extended = failure.status
        self.announce(f'Error: {failure}')

    def _at_rest(self) -> None:
        """Sets the status of a robot without an activity."""
        if self.motors is not Motors.ENABLED:
            self.status = self.extended = self.motors.value
        elif self.lost:
            self.status = self.extended = 'Robot lost'
        elif self.docking.state is DockingState.DOCKED:
            self.status, self.extended = self.docking.line, 'Docked'
        else:
            self.status = self.extended = 'Stopped'

    def stop(self) -> None:
        """Ends the activity, with the robot's lines for it."""
        self._interrupt()
        self.announce_stopping()

    def announce_stopping(self, at_least: float = 0.0) -> None:
        """Brakes; announces `Stopping`, and `Stopped` when the robot stands, after `at_least` s."""
        self.status = self.extended = 'Stopping'
        self.announce('Stopping')

        def stopped() -> None:
            self._at_rest()
            self.announce('Stopped')

        self.executive.brake(then=stopped, at_least=at_least)

    def halt(self) -> None:
        """Ends the activity silently."""
        self._drop_activity()
        self.executive.brake()
        self._at_rest()

    def set_course(self, x: float, y: float, heading: Optional[float]) -> None:
        """Sends the base to a place, like `Navigation.set_course`."""
        self.executive.set_course(x, y, heading)

    def follow(self, manoeuvres: List[Manoeuvre]) -> None:
        """Makes the standing base carry out manoeuvres."""
        self.executive.follow(manoeuvres)

    # -- what forbids driving ------------------------------------------------------------------

    @property
    def can_drive(self) -> bool:
        """Motors on, localized and not blocked."""
        return self.motors is Motors.ENABLED and not self.lost and not self.blocked_by

    def block(self, kind: str, name: str) -> None:
        """Forbids driving from now on, and cancels the activity."""
        self.unblock(kind, name)
        self.blocked_by.append((kind, name))
        self._note_state()

        def end() -> None:
            if self.activity is not None:
                self.stop()

        self.executive.outside(end)

    def unblock(self, kind: str, name: str) -> bool:
        """Removes a reason that forbids driving; False if it did not exist."""
        known = (kind, name) in self.blocked_by
        if known:
            self.blocked_by.remove((kind, name))
            self._note_state()
        return known

    def press_estop(self) -> None:
        """Presses the emergency stop button: motors off, the activity has ended."""
        self.cut_motors(Motors.ESTOP)

    def cut_motors(self, motors: Motors) -> None:
        """Motors off: the activity has ended, and nothing is resumed."""
        self._drop_activity()
        self.executive.brake(self.base.limits.emergency_deceleration)
        self._set_motors(motors)

    def release_estop(self) -> None:
        """Releases the button; the motors stay off."""
        if self.motors is Motors.ESTOP:
            self._set_motors(Motors.RELIEVED)

    def _set_motors(self, motors: Motors) -> None:
        self.motors = motors
        self._note_state()
        self._at_rest()
        self.announce(motors.value)

    def enable_motors(self) -> bool:
        """Switches the motors on; False while the button is pressed."""
        if self.motors is Motors.ESTOP:
            return False
        if self.motors is not Motors.ENABLED:
            self.motors = Motors.ENABLED
            self._note_state()
            self.announce(Motors.ENABLED.value)
            self.announce_stopping()
        return True

    def push(self, pose: Pose) -> None:
        """A person pushes the robot to `pose`, with the motors switched off.

        The robot stays localized.
        """
        self.cut_motors(Motors.DISABLED)
        if self.docking.state is not DockingState.UNDOCKED:
            self.docking.enter(DockingState.UNDOCKED, ChargeState.NOT)
        self.base.put(pose)
        self._at_rest()

    # -- localization ------------------------------------------------------------------------

    def localize(self, pose: Pose, spread: Tuple[float, float] = FOUND_WITHIN) -> None:
        """Searches for itself around `pose`; the robot is lost if it is not there."""
        self.localization.search(pose, self.base.pose, spread)
        if self.lost:
            self.executive.outside(self._end_as_lost)
        elif self.status == 'Robot lost':
            self._at_rest()

    def lose(self, error: Pose) -> None:
        """Makes the believed pose wrong by `error`, and ends the activity."""
        self.localization.error = error
        self._end_as_lost()

    def _end_as_lost(self) -> None:
        if self.activity is not None:
            self._drop_activity()
            self.executive.brake()
            self.announce('Error: Robot lost')
        self._at_rest()
