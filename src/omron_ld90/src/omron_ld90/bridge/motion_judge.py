"""Judges what the robot does, as the reports of the route protocol tell it (`Motion`).

    | the first condition that holds                                         | motion            |
    |------------------------------------------------------------------------|-------------------|
    | a route runs                                                           | ON_ROUTE          |
    | a link is down, or the location is unknown or old                      | UNKNOWN           |
    | another giver or a person's hand drives it, as the controller tells    | MOVED             |
    | it rests, and owes no stop                                             | STANDING          |
    | a route was complete, and nothing else happened since                  | ON_ROUTE          |
    | a route was lost or stopped, and nothing else happened since           | COMING_TO_REST    |
    | it moved without a drive of ours                                       | MOVED             |
    | nothing is known from before the start of this program                 | UNKNOWN           |

It rests if its status shows no motion and its locations stay within STILL for RESTING. Only
locations count that come after the end of the route, and after the last time that it moved. The
first of them is the centre, so a slow movement is seen as well.
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
    """Knows whether the robot rests, and if not, why it moves."""

    def __init__(self) -> None:
        self._rests = False
        self._otherwise = Motion.UNKNOWN  # the motion of a robot that does not rest
        self._centre: Optional[MapLocation] = None
        self._is_driven = False  # by another giver or by hand

    def route_ended(self, phase: Phase) -> None:
        """Notes that a route is complete, or was lost or stopped:
        the robot may roll on for a while.
        """
        self._move(Motion.ON_ROUTE if phase is Phase.COMPLETE else Motion.COMING_TO_REST)

    def taken_over(self) -> None:
        """Notes that something else than a route of ours moves the robot now, or may do so."""
        self._move(Motion.MOVED)

    def told(self, motion: p.MotionTold) -> None:
        """Notes that the controller tells what the robot does, and which giver drives it."""
        self._is_driven = motion.state is MotionState.MANUAL or (
            motion.state in _DRIVEN and not motion.is_ours)
        if self._is_driven:
            self.taken_over()

    def seen(self, status: p.RobotSeen, location: Optional[MapLocation], runs: bool) -> None:
        """Notes that the robot tells what it did at its last location; `location` is None if that
        is no new one.

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
        is_known  -- the links are up, and the location is a recent one
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
