"""The goal that we last sent the robot to, and whether the robot obeys.

Normally the controller reports how a command ended. It cannot do so if its link or the controller
itself was lost, or if this program was restarted. Then the robot's status decides, and only a
command that did not reach the robot is given again.
"""
from __future__ import annotations

import math
from enum import Enum
from typing import Iterable, Optional, Tuple

from omron_ld90.bridge.events import CommandEnded, Ending, Motion, RobotSeen
from omron_ld90.bridge.own_goals import DOCK, OwnGoals
from route_protocol.values import EMERGENCY_STOP, TAKEN_OVER, Reason, ReasonCode

STOP = 'stop'
REASON_DELAY = 0.5  # s after an interruption in which an emergency stop may be its reason
UNMOVED = 0.1       # m by which the location of a standing robot may vary
STATUS_LAG = 1.0    # s by which a status may be older than the last command

_UNCLEAR = (Motion.UNKNOWN, Motion.STOPPING)  # these do not show what the robot does next
_AT_REST = (Motion.STANDING, Motion.ARRIVED, Motion.DOCKED, *_UNCLEAR)


class Knowledge(Enum):
    """How the end of the command becomes known."""

    NOTHING = 'no goal was sent'
    AWAITED = 'the controller will report how it ends'
    DOUBTFUL = 'it is not known yet whether the robot obeys it'
    WATCHED = 'the robot is on its way; its status will show the end'


class RouteFailed(Exception):
    """The route cannot go on; `reason` is for the fleet manager, `detail` for a person here."""

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
    """Tracks the last goal from the command to the arrival."""

    def __init__(self) -> None:
        self.goals = OwnGoals()
        self.reached = False
        """Whether the robot has reported its arrival."""
        self.knowledge = Knowledge.NOTHING
        self.command = ''
        self.number: Optional[int] = None  # of the command whose end is awaited
        self.give_again = False
        """Whether the command did not reach the robot."""
        self.failure: Optional[RouteFailed] = None
        """Why the robot does not obey the command, if it does something else."""
        self.rested_at_goal = 0
        """How many locations in a row since its arrival show the robot at the same place."""
        # The last status before the command; None if it does not help, e.g. after a later stop.
        self._before: Optional[RobotSeen] = None
        self._last: Optional[RobotSeen] = None
        self._place: Optional[Tuple[float, float]] = None
        self._place_before: Optional[Tuple[float, float]] = None
        self._doubted_at = -math.inf
        self._interruption: Optional[Tuple[float, str]] = None
        self._never_sent = False
        self._strange_since: Optional[float] = None  # since when each status contradicts the goal

    @property
    def goal(self) -> Optional[str]:
        """Name of the goal last sent; DOCK for the dock, None if we sent the robot nowhere."""
        return self.goals.current

    @property
    def has_docked(self) -> bool:
        """Whether the robot has reported that it is docked after we sent it to the dock."""
        return self.goal == DOCK and self.reached

    @property
    def is_doubtful(self) -> bool:
        """Whether it is unknown if the robot obeys the last command, or why it no longer does."""
        return self.knowledge is Knowledge.DOUBTFUL or self._interruption is not None

    # --- our commands ----------------------------------------------------------------------------

    def send(self, goal: str, command: str, via: Iterable[str] = ()) -> None:
        """Sends the robot to `goal` (a goal's name, or DOCK), over the goals `via`."""
        self.goals.send(goal, via)
        self._reset()
        self.command = command
        self._before, self._place_before = self._last, self._place
        self.give_again = True

    def given(self, number: int) -> None:
        """The command was given with this number."""
        self.number = number
        self.give_again = self._never_sent = False
        self.knowledge = Knowledge.AWAITED

    def resume(self, goal: Optional[str], now: float) -> None:
        """The robot was sent to `goal` before a restart of this program: checks if it obeys."""
        self.goals.resume(goal)
        self._reset()
        if goal is not None:
            self._doubt(now)

    def forget(self) -> None:
        """Forgets why the last route ended."""
        self.failure = self._interruption = None

    def end(self) -> None:
        """The robot need not drive to a goal of ours any more."""
        self.goals.end()
        self._reset()

    def _reset(self) -> None:
        self.reached = False
        self.knowledge = Knowledge.NOTHING
        self.number = None
        self.give_again = False
        self.failure = None
        self._before = None
        self._interruption = None
        self._never_sent = False
        self._strange_since = None

    # --- how the command goes on -----------------------------------------------------------------

    def ended(self, event: CommandEnded, now: float) -> None:
        """A command has ended; all but the last one are ignored."""
        if event.number != self.number:
            return
        self.number = None
        if event.ending is Ending.SUCCEEDED:
            self._arrive()
        elif event.ending in (Ending.INTERRUPTED, Ending.CANCELLED):
            self.interrupted(now, event.text)
        elif event.ending is Ending.OVERRULED:
            self._never_sent = True
            self.interrupted(now, event.text)
        elif event.ending is Ending.EMERGENCY_STOPPED:
            self.failure = RouteFailed(EMERGENCY_STOP)
        elif event.ending is Ending.FAILED:
            self.failure = RouteFailed(Reason(ReasonCode.DRIVE_FAILED, event.text))
        else:
            self._never_sent = event.ending is Ending.NEVER_SENT
            self._doubt(now)

    def located(self, place: Tuple[float, float], motion: Motion = Motion.UNKNOWN) -> None:
        """Takes a location (m); while the robot still drives, it dates from before the arrival."""
        stands = (motion is not Motion.GOING and self._place is not None
                  and math.dist(self._place, place) <= UNMOVED)
        self._place = place
        if self.reached:
            self.rested_at_goal = self.rested_at_goal + 1 if stands else 0

    def seen(self, status: RobotSeen, now: float, link_stands_since: float) -> None:
        """Takes a status; `link_stands_since` is infinite while no command can reach the robot."""
        self._last = status
        if status.motion is Motion.STOPPING and not self._is_as_before(status):
            self._before = None
        self.goals.seen(status, self.knowledge is Knowledge.AWAITED)
        if self.knowledge is Knowledge.DOUBTFUL:
            self._resolve(status, now, link_stands_since)
        elif self.knowledge is Knowledge.WATCHED:
            self._watch(status, now)

    def interrupted(self, now: float, words: str) -> None:
        """The robot does something else; an emergency stop reported next may be the reason."""
        self.give_again = False
        self._interruption = self._interruption or (now, words)

    def goes_on(self, now: float) -> None:
        """No other giver did anything, so a drive that was refused because of its epoch may be
        given again."""
        if self._never_sent and self._interruption is not None:
            self._interruption = None
            self._doubt(now)

    def obeyed(self) -> None:
        """The robot obeys the last drive after all, although another giver came before it."""
        self._interruption = None

    def check_clock(self, now: float) -> None:
        """If no reason for an interruption came in time, another giver caused it."""
        if self._interruption is not None and now - self._interruption[0] > REASON_DELAY:
            self.failure = TakenOver(self._interruption[1] or 'The motion was interrupted.')

    def _arrive(self) -> None:
        self.reached = True
        self.knowledge = Knowledge.NOTHING
        self.rested_at_goal = 0

    def _doubt(self, now: float) -> None:
        self.knowledge = Knowledge.DOUBTFUL
        self._doubted_at = now

    def _resolve(self, status: RobotSeen, now: float, link_stands_since: float) -> None:
        """Decides from the status whether the robot obeys a command whose end was lost."""
        if status.motion in _UNCLEAR and not self._is_as_before(status):
            return
        settled = now >= self._doubted_at + STATUS_LAG
        if self.goals.is_obeyed(status) and not self._never_sent:
            if settled:
                self.knowledge = Knowledge.WATCHED
                self._watch(status, now)
        elif not self._is_as_before(status):
            self._contradict(status, now)
        elif settled and now >= link_stands_since + STATUS_LAG:
            self._strange_since = None
            self.give_again = True

    def _watch(self, status: RobotSeen, now: float) -> None:
        """Takes the end of the command from the robot's status: no other message will report it."""
        if status.motion in _UNCLEAR:
            return
        if (status.motion is Motion.ARRIVED and status.goal == self.goal) or (
                self.goal == DOCK and status.motion is Motion.DOCKED):
            self._arrive()
        elif status.motion is Motion.FAILED and status.goal == self.goal:
            self.failure = RouteFailed(Reason(
                ReasonCode.DRIVE_FAILED, f'Failed going to {status.goal}'))
        elif self.goals.is_obeyed(status):
            self._strange_since = None
        else:
            self._contradict(status, now)

    def _contradict(self, status: RobotSeen, now: float) -> None:
        """The robot does something else: allowed for an instant, but not for longer.

        A new goal that is not ours belongs to another giver at once.
        """
        shown_before = self._before is not None and self._before.goal == status.goal
        foreign = (status.motion is Motion.GOING and status.goal not in self.goals
                   and not shown_before)
        if self._strange_since is None:
            self._strange_since = now
        if foreign or now - self._strange_since >= STATUS_LAG:
            self.failure = TakenOver(_what_it_does(status))

    def _is_as_before(self, status: RobotSeen) -> bool:
        """Whether the robot does the same as before the command, so that it did not receive it."""
        if self.goals.is_earlier_obeyed(status):
            return True
        before, now = self._place_before, self._place
        return (self._before is not None and _rests_as(self._before, status)
                and before is not None and now is not None
                and math.dist(before, now) <= UNMOVED)


def _rests_as(before: RobotSeen, status: RobotSeen) -> bool:
    """Whether the robot rests as `before`; the status of a robot stopped since then differs."""
    if before.motion in _UNCLEAR:
        return status.motion in _AT_REST
    return before.motion in _AT_REST and status.motion in (before.motion, Motion.UNKNOWN)


def _what_it_does(status: RobotSeen) -> str:
    if status.motion is Motion.GOING:
        return f'The robot is going to {status.goal or "another place"}.'
    return f'The robot is {status.motion.value} {status.goal}'.rstrip() + '.'
