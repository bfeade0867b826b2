"""The robot: one body on one floor, with one activity at a time.

The robot sends `Interrupted:` if another activity replaces the present one. It announces events to
all clients through `announce`. Its `executive` carries out the activities; its `permission` shows
whether it may drive. Events from outside and their effects:

    event                        activity           status at rest         lines
    another activity starts      replaced           its own                Interrupted
    stop, a reason to block      ends, brakes       Stopped                Interrupted, Stopping,
                                                                           Stopped
    halt                         ends, brakes       Stopped                none
    motors cut, button pressed   ends, brakes hard  text of MotorState     text of MotorState
    motors enabled               none runs          Stopped                Motors enabled,
                                                                           Stopping, Stopped
    the script fails             ends, brakes       status of the failure  Error
    the robot is lost            ends, brakes       Robot lost             Error: Robot lost

Invariants: there is one activity at most; none runs while the motors are off. The robot is docking
or undocking only while an activity runs.
"""
from __future__ import annotations

import random
from dataclasses import dataclass, field
from typing import Callable, Dict, Optional, Set, Tuple

import numpy as np

from omron_ld90_sim.behaviour.docking import Docking
from omron_ld90_sim.behaviour.executive import Executive
from omron_ld90_sim.behaviour.permission import DrivePermission, PermissionChange
from omron_ld90_sim.behaviour.state_times import StateTimes, WorkState
from omron_ld90_sim.behaviour.states import (
    ActivityFailure,
    DockingPhase,
    InterruptedWords,
    MotorState,
    ScriptedActivity,
)
from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.devices import laser
from omron_ld90_sim.devices.battery import ChargeState
from omron_ld90_sim.devices.equipment import Equipment
from omron_ld90_sim.devices.localization import FOUND_WITHIN, Localization
from omron_ld90_sim.devices.odometer import SimOdometer
from omron_ld90_sim.devices.scanner import Scanner
from omron_ld90_sim.motion.base import Base
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose, normalise
from omron_ld90_sim.motion.navigation import Navigation
from omron_ld90_sim.motion.places import docked_pose, start_places
from omron_map import MapDocument


@dataclass
class Quirks:
    """How this robot differs from an ideal one.

    arrival_error -- the largest error (mm, deg) with which the robot stops at a goal
    failing_goals -- goals that the robot fails to reach, in lower case
    failing_docks -- how many of the next drives into a dock fail
    stops_to_replace -- whether the robot sends `Stopping` when an activity is replaced
    speed_limit -- mm/s, for every drive
    """

    arrival_error: Tuple[float, float] = (0.0, 0.0)
    failing_goals: Set[str] = field(default_factory=set)
    failing_docks: int = 0
    interrupted_words: InterruptedWords = InterruptedWords.NAME
    stops_to_replace: bool = False
    speed_limit: Optional[float] = None


@dataclass
class TaskState:
    """The state of the robot's tasks.

    last_goal -- the goal of its last drive
    waiting -- status text of the running wait task; empty: no wait task runs
    pausing -- whether a pause task runs
    patrol_places -- index of the present goal on each route, by the route's name in lower case
    """

    last_goal: str = ''
    waiting: str = ''
    pausing: bool = False
    patrol_places: Dict[str, int] = field(default_factory=dict)


class SimRobot:
    """One simulated LD-90 without its interface; lengths in mm, angles in degrees.

    It has many attributes because it puts the parts of a robot together: each attribute is a part.
    """

    def __init__(self, clock: SimClock, document: MapDocument, floor: SimFloor,
                 start: Optional[SimPose], seed: int = 0, battery: float = 100.0,
                 announce: Callable[[str], None] = lambda line: None,
                 arrival_error: Tuple[float, float] = (0.0, 0.0)) -> None:
        self.clock, self.announce = clock, announce
        self.random = random.Random(seed)
        self.scanner = Scanner(clock, seed)
        self.status = self.extended = 'Stopped'
        self.permission = DrivePermission(self._permission_changed)
        self.quirks = Quirks(arrival_error)
        self.tasks = TaskState()
        self.equipment = Equipment()
        self.localization = Localization(clock, seed)
        self.document = document
        self.base = Base(start or start_places(document, floor, [None])[0])
        self.docking = Docking(clock, self.base, battery, self._docking_changed)
        self.odometer = SimOdometer(self.base, clock)
        self.state_times = StateTimes(clock, self.base)
        self.navigation = Navigation(self.base, floor)
        self.executive = Executive(clock, self.navigation, self.docking.update, self._failed)
        self._dock_at_start()

    # -- the world ---------------------------------------------------------------------------

    def load_map(self, document: MapDocument, floor: SimFloor) -> None:
        """Loads another map; the robot stays where it is."""
        self.document = document
        self.navigation.change_floor(floor)

    def _dock_at_start(self) -> None:
        """Sets the docking state of a robot that starts in a dock."""
        here = self.base.pose
        for dock in self.document.docks:
            inside = docked_pose(self.navigation.floor, dock)
            if (here.distance_to(inside.x, inside.y) < 1.0
                    and abs(normalise(here.theta - inside.theta)) < 1.0):
                self.docking.begin_docked()
                self._note_state()
                self._at_rest()

    @property
    def true_pose(self) -> SimPose:
        """The true pose of the body."""
        return self.base.pose

    @property
    def pose(self) -> SimPose:
        """The pose that the robot believes and reports."""
        return self.localization.believed(self.base.pose)

    def scan(self) -> np.ndarray:
        """Returns one laser scan: hits (N, 2) in mm, map frame, as seen from the believed pose."""
        return self.scanner.scan(self.navigation.floor, self.true_pose, self.pose,
                                 self.navigation.outlines(laser.RANGE))

    def _docking_changed(self) -> None:
        if self.docking.state is not DockingPhase.UNDOCKED:
            self.status = self.docking.line
        self._note_state()
        self.announce(self.docking.line)

    def _note_state(self) -> None:
        """Updates the working state. The data store shows how long the robot was in each state."""
        if self.permission.motors in (MotorState.ESTOP, MotorState.RELIEVED):
            state: Optional[WorkState] = WorkState.IN_ESTOP
        elif any(kind == 'fault' for kind, _ in self.permission.blocked_by):
            state = WorkState.IN_FAULT
        else:
            state = {DockingPhase.DOCKING: WorkState.DOCKING,
                     DockingPhase.DOCKED: WorkState.DOCKED}.get(self.docking.state)
        self.state_times.enter(state)

    # -- activities --------------------------------------------------------------------------

    @property
    def activity(self) -> Optional[ScriptedActivity]:
        """The present activity, if any."""
        return self.executive.activity

    def start(self, activity: ScriptedActivity) -> None:
        """Replaces the activity. The base brakes, unless the new one sets a course at once."""
        if self._interrupt() and self.quirks.stops_to_replace:
            self.announce('Stopping')
        self.navigation.speed_limit = self.quirks.speed_limit
        self.status, self.extended = activity.status, activity.extended
        self.executive.run(activity)

    def _interrupt(self) -> bool:
        """Ends the activity. Returns False if there was none."""
        interrupted = self.activity is not None
        if self.activity is not None:
            line = self.activity.interrupted(self.quirks.interrupted_words)
            self._drop_activity()
            if line is not None:
                self.announce(line)
        return interrupted

    def _drop_activity(self) -> None:
        self.executive.drop()
        self._give_up_docking()

    def _give_up_docking(self) -> None:
        if self.docking.state in (DockingPhase.DOCKING, DockingPhase.UNDOCKING):
            self.docking.enter(DockingPhase.UNDOCKED, ChargeState.NOT)

    def _failed(self, failure: ActivityFailure) -> None:
        self._give_up_docking()
        self.status = self.extended = failure.status
        self.announce(f'Error: {failure}')

    def _at_rest(self) -> None:
        """Sets the status of a robot without an activity."""
        if self.permission.motors is not MotorState.ENABLED:
            self.status = self.extended = self.permission.motors.value
        elif self.localization.lost:
            self.status = self.extended = 'Robot lost'
        elif self.docking.state is DockingPhase.DOCKED:
            self.status, self.extended = self.docking.line, 'Docked'
        else:
            self.status = self.extended = 'Stopped'

    def stop(self) -> None:
        """Ends the activity, and sends the robot's lines about this."""
        self._interrupt()
        self.announce_stopping()

    def announce_stopping(self, at_least: float = 0.0) -> None:
        """Brakes and announces `Stopping`, then `Stopped` when the robot stands.

        at_least -- s until `Stopped` if the robot stands already
        """
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

    # -- whether it may drive ------------------------------------------------------------------

    @property
    def can_drive(self) -> bool:
        """Whether the motors are on, and the robot is localized and not blocked."""
        return self.permission.granted and not self.localization.lost

    def _permission_changed(self, change: PermissionChange) -> None:
        if change is PermissionChange.MOTORS_CUT:
            self._drop_activity()
            self.executive.brake(self.base.limits.emergency_deceleration)
        self._note_state()
        if change is PermissionChange.BLOCKED:
            self.executive.outside(self._end_as_blocked)
        elif change is not PermissionChange.UNBLOCKED:
            self._at_rest()
            self.announce(self.permission.motors.value)
        if change is PermissionChange.MOTORS_ENABLED:
            self.announce_stopping()

    def _end_as_blocked(self) -> None:
        if self.activity is not None:
            self.stop()

    def push(self, pose: SimPose) -> None:
        """Lets a person push the robot to `pose`, with the motors switched off.

        The robot stays localized.
        """
        self.permission.cut_motors()
        if self.docking.state is not DockingPhase.UNDOCKED:
            self.docking.enter(DockingPhase.UNDOCKED, ChargeState.NOT)
        self.base.put(pose)
        self._at_rest()

    # -- localization ------------------------------------------------------------------------

    def localize(self, pose: SimPose, spread: Tuple[float, float] = FOUND_WITHIN) -> None:
        """Makes the robot search for itself around `pose`. If it is not there, it gets lost."""
        self.localization.search(pose, self.base.pose, spread)
        if self.localization.lost:
            self.executive.outside(self._end_as_lost)
        elif self.status == 'Robot lost':
            self._at_rest()

    def lose(self, error: SimPose) -> None:
        """Makes the believed pose wrong by `error`, and ends the activity."""
        self.localization.error = error
        self._end_as_lost()

    def _end_as_lost(self) -> None:
        if self.activity is not None:
            self._drop_activity()
            self.executive.brake()
            self.announce('Error: Robot lost')
        self._at_rest()
