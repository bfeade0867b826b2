"""The last goal to which we sent the robot, and how the drive to this goal ends.

    the drive is   event                                       the drive becomes
    under way      SUCCEEDED                                   reached
    under way      EMERGENCY_STOPPED, FAILED                   failed
    under way      LOST, INTERRUPTED, CANCELLED, OVERRULED     lost: `motion` will show its fate
    lost           `motion` shows COMPLETED                    reached
    lost           `motion` shows FAILED                       failed
    lost           `motion` shows NOT_OBEYED                   under way: it is given again

Invariants: only the last command counts; a new command replaces all that is known about earlier
ones. A drive is given again only if the robot does not carry it out; see `last_word`.
"""
from __future__ import annotations

import math
from typing import Optional, Tuple

from omron_arcl import ActivityKind, Outcome
from omron_arcl.activity import MOVING
from omron_arcl.records import CommandFate
from omron_ld90.bridge.events import CommandEnded
from omron_ld90.bridge.last_word import STOP, LastWord
from route_protocol.values import EMERGENCY_STOP, TAKEN_OVER, Reason, ReasonCode

DOCK = 'dock'
UNMOVED = 0.1       # m by which the location of a standing robot may vary

_FAILED = Reason(ReasonCode.DRIVE_FAILED, 'the robot failed to reach its goal')


class RouteFailed(Exception):
    """The route cannot go on. `reason` is for the fleet manager, `detail` for a person."""

    def __init__(self, reason: Reason, detail: str = '') -> None:
        super().__init__(reason, detail)
        self.reason = reason
        self.detail = detail

    def __str__(self) -> str:
        return f'{self.reason.text.rstrip(".")}. {self.detail}'.rstrip()


class TakenOver(RouteFailed):
    """The robot already obeys another giver, so the bridge must not stop it."""

    def __init__(self, how: str) -> None:
        super().__init__(TAKEN_OVER, how)


class GoalTracker:
    """Tracks the last goal from the command to the arrival.

    There is one method for each command of ours, and one for each event.
    """

    def __init__(self) -> None:
        self.goal: Optional[str] = None
        """Name of the last goal; DOCK for the dock, None if we sent the robot to no goal."""
        self.word = LastWord()
        """The last command: the drive to the goal, or a stop."""
        self.reached = False
        """Whether the robot has reported its arrival."""
        self.failure: Optional[RouteFailed] = None
        """Why the drive has failed; None: it has not."""
        self.rested_at_goal = 0
        """Number of successive locations since the arrival that show the robot at one place."""
        # number and fate of our last command, as `motion` shows them
        self._told: Tuple[int, Optional[CommandFate]] = (0, None)
        self._place: Optional[Tuple[float, float]] = None

    @property
    def has_docked(self) -> bool:
        """Whether the robot has reported that it is docked after we sent it to the dock."""
        return self.goal == DOCK and self.reached

    @property
    def awaits_motion(self) -> bool:
        """Whether only `motion` can show the fate of the last command, and has not shown it yet."""
        return self.word.is_lost

    # --- our commands ----------------------------------------------------------------------------

    def send(self, goal: str, command: str) -> None:
        """Sends the robot to `goal` (a goal's name, or DOCK)."""
        self._begin(goal, LastWord(command))

    def resume(self, goal: str, command: str, number: int, now: float) -> None:
        """Notes that the robot was sent to `goal` before a restart of this program.

        number -- the number of the command; 0: the command was not given yet
        """
        self._begin(goal, LastWord(command, number=number))
        self._judge(now)

    def stop(self, epoch: int) -> None:
        """Gives a stop as soon as the robot can be reached. The stop does not end a drive that
        another giver began after `epoch`; 0: it ends any drive.
        """
        self._begin(None, LastWord(STOP, epoch))

    def forget(self) -> None:
        """Forgets why the last route failed, and forgets the last command if it was a stop."""
        self.failure = None
        if self.word.is_stop:
            self.word = LastWord()

    def end(self) -> None:
        """Notes that the robot need not drive to a goal of ours any more."""
        self._begin(None, self.word if self.word.is_stop else LastWord())

    def _begin(self, goal: Optional[str], word: LastWord) -> None:
        self.goal, self.word = goal, word
        self.reached = False
        self.failure = None

    # --- how the command goes on -----------------------------------------------------------------

    def ended(self, event: CommandEnded, now: float) -> None:
        """Notes that a command has ended. Ends of older commands are ignored."""
        if event.number != self.word.number or self.word.must_be_given:
            return
        self.word.ended(event, now)
        if self.word.is_stop:
            return
        if event.ending is Outcome.SUCCEEDED:
            self._arrive()
        elif event.ending is Outcome.EMERGENCY_STOPPED:
            self.failure = RouteFailed(EMERGENCY_STOP)
        elif event.ending is Outcome.FAILED:
            self.failure = RouteFailed(Reason(ReasonCode.DRIVE_FAILED, event.text))
        else:
            self._judge(now)

    def told(self, number: int, fate: Optional[CommandFate], now: float) -> None:
        """Notes the fate of our last command, as the controller has published it."""
        self._told = number, fate
        self._judge(now)

    def _judge(self, now: float) -> None:
        if self._told[0] > self.word.number and self.word.is_lost:
            self.end()
        fate = self.word.told(self._told, now)
        if fate is CommandFate.COMPLETED:
            self._arrive()
        elif fate is CommandFate.FAILED:
            self.failure = RouteFailed(_FAILED)

    def located(self, place: Tuple[float, float], activity: ActivityKind = ActivityKind.UNKNOWN
                ) -> None:
        """Takes a location (m), which is older than the arrival if its status shows motion."""
        stands = (activity not in MOVING and self._place is not None
                  and math.dist(self._place, place) <= UNMOVED)
        self._place = place
        if self.reached:
            self.rested_at_goal = self.rested_at_goal + 1 if stands else 0

    def _arrive(self) -> None:
        self.reached = True
        self.rested_at_goal = 0
