"""Checks every step of a driving robot: its limits, and that it does not collide."""
from __future__ import annotations

from typing import Tuple

import numpy as np
from sim_builders import Obstacles

from omron_ld90_sim.motion.base import STEP, Base
from omron_ld90_sim.motion.kinematics import LD90_BODY, LD90_LIMITS, SimPose
from omron_ld90_sim.motion.track import Turn


class Inspector:
    """Records the steps of a base; `check` compares them with obstacles and limits."""

    def __init__(self, obstacles: Obstacles, base: Base) -> None:
        # the body never crosses the border of an area, so only its start must be checked
        assert not obstacles.forbidden(base.pose)
        self.obstacles, self.base = obstacles, base
        self._rows = [self._row(False)]
        self._step, base.step = base.step, self.step

    def _row(self, turning: bool) -> Tuple[float, ...]:
        pose = self.base.pose
        return pose.x, pose.y, pose.theta, self.base.speed, self.base.rotation, turning

    @property
    def steps(self) -> int:
        """The number of recorded steps."""
        return len(self._rows) - 1

    def step(self, dt: float = STEP) -> None:
        """Makes a step and records it."""
        turning = isinstance(self.base.manoeuvre, Turn)
        self._step(dt)
        self._rows.append(self._row(turning))

    def drive(self, seconds: float = 1000.0) -> None:
        """Steps the base to its end and checks all steps."""
        while not self.base.still:
            self.base.step()
            assert self.steps * STEP < seconds, 'the robot did not arrive'
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
        # the body cannot touch anything farther away than half its diagonal
        for number in np.flatnonzero(clear <= LD90_BODY.half_diagonal):
            pose = SimPose(*rows[number + 1, :3])
            assert self.obstacles.distance(pose) > 0.0, f'collision at {pose}'

    def _hold(self, held: np.ndarray, fault: str) -> None:
        broken = np.flatnonzero(~held)
        assert not len(broken), f'{fault} at {SimPose(*self._rows[broken[0] + 1][:3])}'
