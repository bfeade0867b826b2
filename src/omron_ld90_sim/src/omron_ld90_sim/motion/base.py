"""The moving base: carries out manoeuvres step by step within the robot's limits."""
from __future__ import annotations

import math
from collections import deque
from typing import Deque, List, Optional

from omron_ld90_sim.motion.kinematics import LD90_LIMITS, Limits, SimPose, normalise
from omron_ld90_sim.motion.track import Manoeuvre, SmoothTrack, Turn

STEP = 0.05             # s between two steps while moving
BISECTIONS = 10
CLOSE = 0.05            # mm and deg; a manoeuvre ends when less than this is left
CREEP = 5.0             # mm/s and deg/s, lowest speed at the end of a manoeuvre


class Base:
    """Pose and speeds of the robot, and its remaining manoeuvres."""

    def __init__(self, pose: SimPose, limits: Limits = LD90_LIMITS) -> None:
        self.pose, self.limits = pose, limits
        self.speed = 0.0            # mm/s along the driving direction, never negative
        self.rotation = 0.0         # deg/s, left positive
        self.driven = 0.0           # mm since the start, sum of both directions
        self.turned = 0.0           # deg since the start, sum of both directions
        self._queue: Deque[Manoeuvre] = deque()
        self._place = 0.0           # position on the first manoeuvre: mm, or deg of a turn
        self._braking: Optional[float] = None

    @property
    def still(self) -> bool:
        """Whether the base stands and has no manoeuvres left."""
        return not self._queue and self.speed == 0.0 and self.rotation == 0.0

    @property
    def manoeuvre(self) -> Optional[Manoeuvre]:
        """The present manoeuvre, if any."""
        return self._queue[0] if self._queue else None

    @property
    def track(self) -> Optional[SmoothTrack]:
        """The present track, if the manoeuvre is one."""
        return self._queue[0] if self._queue and isinstance(self._queue[0], SmoothTrack) else None

    @property
    def place(self) -> float:
        """Arc length (mm) on `track`."""
        return self._place

    @property
    def braking(self) -> bool:
        """Whether the base is braking."""
        return self._braking is not None

    def follow(self, manoeuvres: List[Manoeuvre]) -> None:
        """Replaces the remaining manoeuvres; the first new one must continue the present motion."""
        self._queue = deque(manoeuvres)
        self._place = 0.0
        self._braking = None

    def brake(self, deceleration: Optional[float] = None) -> None:
        """Brakes to a stop during the present manoeuvre, and drops the manoeuvres after it.

        A later call can only make the braking harder. `deceleration` is in mm/s2. In a bend the
        base brakes less, because its rotation must not change too fast.
        """
        if self._queue:
            self._queue = deque([self._queue[0]])
            self._braking = max(deceleration or self.limits.deceleration, self._braking or 0.0)
            if self.speed == 0.0 and self.rotation == 0.0:
                self._halt()

    def put(self, pose: SimPose) -> None:
        """Puts the robot at another pose; this distance is not counted as driven."""
        self._halt()
        self.pose = pose

    def _halt(self) -> None:
        self._queue.clear()
        self.speed = self.rotation = self._place = 0.0
        self._braking = None

    def step(self, dt: float = STEP) -> None:
        """Moves for `dt` seconds."""
        if not self._queue:
            return
        before = self.pose
        current = self._queue[0]
        done = self._turn(current, dt) if isinstance(current, Turn) else self._drive(current, dt)
        self.driven += self.pose.distance_to(before.x, before.y)
        self.turned += abs(normalise(self.pose.theta - before.theta))
        if done:
            self._queue.popleft()
            self._place = self.speed = self.rotation = 0.0
        if self._braking is not None and self.speed == 0.0 and self.rotation == 0.0:
            self._halt()

    def _turn(self, turn: Turn, dt: float) -> bool:
        left = (normalise(turn.heading - self.pose.theta) if turn.angle is None
                else turn.angle - self._place)
        sign = math.copysign(1.0, left)
        change = self.limits.rotation_acceleration * dt
        now = abs(self.rotation)
        if self._braking is not None:
            wanted = 0.0
        else:
            # the highest rate from which the robot can stop within the remaining angle
            wanted = math.sqrt(change * change / 4 + 2 * self.limits.rotation_acceleration
                               * max(abs(left) - now * dt / 2, 0.0)) - change / 2
            wanted = min(max(wanted, CREEP), turn.rate)
        if now <= change and abs(left) <= now * dt / 2 + CLOSE and self._braking is None:
            self.pose = SimPose(self.pose.x, self.pose.y, normalise(turn.heading))
            return True
        rate = min(max(wanted, now - change), now + change)
        moved = min((now + rate) / 2 * dt, abs(left))
        self.rotation = sign * rate
        self._place += sign * moved
        self.pose = SimPose(self.pose.x, self.pose.y, normalise(self.pose.theta + sign * moved))
        return False

    def _drive(self, track: SmoothTrack, dt: float) -> bool:
        now = self.speed
        if self._braking is not None:
            slow = min(self._braking, track.acceleration_at(self._place))
            speed = max(now - slow * dt, 0.0)
        else:
            slowest = max(now - self.limits.deceleration * dt, 0.0)
            speed = now + min(self.limits.acceleration, track.acceleration_at(self._place)) * dt
            speed = self._allowed(track, slowest, speed, now, dt)
            if (now <= self.limits.deceleration * dt
                    and track.length - self._place <= now * dt / 2 + CLOSE):
                self.pose = track.pose_at(track.length)
                return True
        self._place = min(self._place + (now + speed) / 2 * dt, track.length)
        self.speed = speed
        self.pose = track.pose_at(self._place)
        self.rotation = math.degrees(track.curvature_at(self._place) * speed)
        return False

    def _allowed(self, track: SmoothTrack, slowest: float, fastest: float, now: float,
                 dt: float) -> float:
        """Returns the highest speed that the track allows at the end of this step."""
        def fits(speed: float) -> bool:
            return speed <= track.speed_at(self._place + (now + speed) / 2 * dt)

        if fits(fastest):
            return fastest
        for _ in range(BISECTIONS):
            middle = (slowest + fastest) / 2
            slowest, fastest = (middle, fastest) if fits(middle) else (slowest, middle)
        return max(slowest, min(CREEP, now))

    @property
    def distance_left(self) -> float:
        """Length (mm) of the remaining tracks."""
        tracks = [part for part in self._queue if isinstance(part, SmoothTrack)]
        return sum(track.length for track in tracks) - (self._place if self.track else 0.0)

    def stopping_distance(self) -> float:
        """Returns the distance (mm) in which the base stops if it brakes now."""
        return self.speed * self.speed / (2.0 * self.limits.deceleration) + self.speed * STEP
