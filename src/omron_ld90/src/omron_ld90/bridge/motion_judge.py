"""Decides what the reports of the route protocol say about the robot's motion (`Motion`).

    | the first condition that holds                                         | motion            |
    |------------------------------------------------------------------------|-------------------|
    | a route runs                                                           | ON_ROUTE          |
    | a link is down, or the location is unknown or old                      | UNKNOWN           |
    | according to the controller, another giver or a person drives it       | MOVED             |
    | the robot rests, and owes no stop                                      | STANDING          |
    | the robot rests, and owes a stop                                       | COMING_TO_REST    |
    | the last event was the end of a complete route                         | ON_ROUTE          |
    | the last event was the end of a lost or stopped route                  | COMING_TO_REST    |
    | the last event was a motion without a drive of ours                    | MOVED             |
    | nothing has happened since the start of this program                   | UNKNOWN           |

The robot rests if its status shows no motion and its locations stay near one centre (`STILL`) for
some time (`RESTING`). A location counts only if it comes after the end of the route and after the
last motion. The first such location is the centre, so a slow motion is seen as well.
"""
from __future__ import annotations

import math
from typing import Optional

from omron_arcl import ActivityKind
from omron_arcl.activity import MOVING
from omron_arcl.records import MotionState
from omron_ld90.bridge import events as p
from omron_ld90.bridge.robot_state import NANOSECONDS, MapLocation
from route_protocol.values import Motion, Phase

STILL = 0.05   # m
RESTING = 1.0  # s

_DRIVEN = (MotionState.DRIVING, MotionState.DOCKING, MotionState.UNDOCKING)
_MOVING = MOVING | {ActivityKind.STOPPING}


class MotionJudge:
    """Finds out whether the robot rests and, if it does not, why it moves."""

    def __init__(self) -> None:
        self._rests = False
        self._otherwise = Motion.UNKNOWN  # the motion of a robot that does not rest
        self._centre: Optional[MapLocation] = None
        self._is_driven = False  # whether another giver or a person drives the robot

    def route_ended(self, phase: Phase) -> None:
        """Notes that a route has ended. The robot may still roll on for a while."""
        self._move(Motion.ON_ROUTE if phase is Phase.COMPLETE else Motion.COMING_TO_REST)

    def taken_over(self) -> None:
        """Notes that something other than a route of ours moves the robot, or may move it."""
        self._move(Motion.MOVED)

    def told(self, motion: p.MotionTold) -> None:
        """Notes the robot's motion and its giver, as the controller reports them."""
        self._is_driven = motion.state is MotionState.MANUAL or (
            motion.state in _DRIVEN and not motion.is_ours)
        if self._is_driven:
            self.taken_over()

    def seen(self, status: p.RobotSeen, location: Optional[MapLocation], runs: bool) -> None:
        """Notes a status of the robot.

        location -- the robot's location if it is a new one, otherwise None
        runs -- a route of ours runs
        """
        if location is None or runs:
            return
        centre = self._centre
        if centre is None or location.stamp < centre.stamp:
            self._centre = location
            return
        has_moved = math.dist(centre.position, location.position) > STILL
        if has_moved or status.activity in _MOVING:
            if has_moved and self._rests:
                self._move(Motion.MOVED)
            self._rests, self._centre = False, location
        elif (location.stamp - centre.stamp) * NANOSECONDS >= RESTING:
            self._rests = True

    def motion(self, runs: bool, is_known: bool, owes_stop: bool) -> Motion:
        """Returns what the robot does.

        runs      -- a route runs
        is_known  -- the links are up, and the location is recent
        owes_stop -- a stop is not obeyed yet
        """
        if runs:
            return Motion.ON_ROUTE
        if not is_known:
            return Motion.UNKNOWN
        if self._is_driven:
            return Motion.MOVED
        if self._rests and not owes_stop:
            return Motion.STANDING
        return Motion.COMING_TO_REST if self._rests else self._otherwise

    def _move(self, why: Motion) -> None:
        self._rests, self._centre, self._otherwise = False, None, why
