"""Whose word counts where several drive one robot: whoever gave it last.

Software that drives the robot along a route gives one drive after another. Where a person stops the
robot, or sends it elsewhere, here or by another client of the robot, that software learns so a
moment later; what it gave meanwhile must not pass the person's word in the robot.
"""
from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import Callable, List, Optional

from omron_arcl.commands import Command
from omron_arcl.errors import ArclError
from omron_arcl.execution import Outcome

LATE = 0.5  # s from a stop, or the end of a drive, until whom it concerns has certainly heard so

# Ends of a motion that never moved or stopped the robot.
_WITHOUT_EFFECT = (Outcome.REJECTED, Outcome.NO_GOAL, Outcome.UNKNOWN_COMMAND, Outcome.LOST)


@dataclass(eq=False)
class Motion:
    """A drive, a stop or the cancellation of a drive that was given.

    stopped: a drive that was cancelled or has timed out, so that a stop of ours follows it.
    own_affair: a stop of whoever drove last, be it at the end of a route: it overrules nobody else.
    superseded_by: what its giver has given since, so that its end tells nothing of others.
    """

    giver: str
    text: str
    given_at: float = -math.inf
    stopped: bool = False
    own_affair: bool = False
    superseded_by: List[Motion] = field(default_factory=list)
    overruled_by: Optional[Motion] = None
    ended_at: float = math.inf


_ANOTHER_CLIENT = 'another client of the robot'


class Overruled(ArclError):
    """A drive whose giver cannot have known of `by`, which somebody else gave before it."""

    def __init__(self, by: Motion) -> None:
        super().__init__(f'Not sent, {by.text} of {by.giver} came first.')
        self.by = by


class Overruling:
    """Refuses drives of those who have been overruled, until they can know it.

    Givers are told apart by any name. The caller holds a lock from `take` until the command is
    given, so that commands are given in the order in which they were taken.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._drives: List[Motion] = []  # under way, or ended less than LATE ago
        self._stops: List[Motion] = []  # under way, or given less than LATE ago
        self._last_driver = ''  # who gave the last drive, long ago or not
        self._powered_at = -math.inf  # the motors were enabled

    def take(self, giver: str, command: Command) -> Optional[Motion]:
        """Takes a command that `giver` gives; None where it is no motion. Raises Overruled."""
        spec = command.spec
        if not (spec.drives or spec.stops):
            return None
        now = self._clock()
        self._drives = [drive for drive in self._drives if now < drive.ended_at + LATE]
        self._stops = [stop for stop in self._stops
                       if stop.ended_at == math.inf or now < stop.given_at + LATE]
        if spec.drives:
            self._check(giver, now)
        motion = Motion(giver, f'"{command.text}"', now, own_affair=giver == self._last_driver)
        for drive in self._drives:
            if drive.giver == giver:
                drive.superseded_by.append(motion)
            elif drive.overruled_by is None and (spec.stops or now < drive.ended_at):
                drive.overruled_by = motion
        if spec.drives:
            self._drives.append(motion)
            self._last_driver = giver
        else:
            self._stops.append(motion)
        return motion

    def _check(self, giver: str, now: float) -> None:
        """Raises Overruled where `giver` cannot know yet what somebody else gave."""
        for drive in self._drives:
            if drive.giver == giver and drive.overruled_by is not None:
                raise Overruled(drive.overruled_by)
        for stop in self._stops:
            if stop.giver != giver and not stop.own_affair and now < stop.given_at + LATE:
                raise Overruled(stop)

    def cancelled(self, motion: Motion, canceller: str) -> None:
        """Somebody cancels a motion; its own giver may do so."""
        motion.stopped = True
        if canceller != motion.giver and motion.overruled_by is None:
            motion.overruled_by = Motion(canceller, 'a cancellation')

    def powered(self) -> None:
        """The robot says that its motors are on; next it says by itself that it stops."""
        self._powered_at = self._clock()

    def stopping(self) -> None:
        """The robot says that it stops: another client stopped it, unless we have.

        Right after a drive was given that may be how a robot replaces the one before.
        """
        now = self._clock()
        ours = (any(stop.ended_at == math.inf for stop in self._stops)
                or any(now < drive.given_at + LATE
                       or drive.stopped and now < drive.ended_at + LATE for drive in self._drives))
        if not ours and now >= self._powered_at + LATE:
            self._stops.append(Motion(_ANOTHER_CLIENT, 'a stop', now, ended_at=now))

    def ended(self, motion: Motion, outcome: Outcome) -> None:
        """A motion has ended, or could not be given."""
        motion.ended_at = self._clock()
        motion.stopped = motion.stopped or outcome is Outcome.TIMED_OUT
        if outcome in _WITHOUT_EFFECT:
            self._stops = [stop for stop in self._stops if stop is not motion]
            for drive in self._drives:
                if motion in drive.superseded_by:
                    drive.superseded_by.remove(motion)
                if drive.overruled_by is motion and drive.ended_at == math.inf:
                    drive.overruled_by = None
        elif (outcome is Outcome.INTERRUPTED and not motion.superseded_by
                and motion.overruled_by is None):
            motion.overruled_by = Motion(_ANOTHER_CLIENT, 'a command')
