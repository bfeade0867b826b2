"""The goal that the robot was last sent to by us, and what is known of its way there.

Normally the controller tells how a command ends. Where it cannot (its link or the controller itself
was lost, or this program was restarted), the robot's status says what the robot does, and only a
command that did not reach the robot is given again.
"""
from __future__ import annotations

import math
from enum import Enum
from typing import Iterable, Optional, Tuple

from omron_ld90.bridge.events import CommandEnded, Ending, Motion, RobotSeen
from omron_ld90.bridge.own_goals import DOCK, OwnGoals
from trajectory_graph.route_protocol import EMERGENCY_STOP, TAKEN_OVER, Reason, ReasonCode

STOP = 'stop'
REASON_DELAY = 0.5  # s for an emergency stop to be told after the motion that it interrupted
UNMOVED = 0.1       # m, that a standing robot may seem to move
STATUS_LAG = 1.0    # s that a status may be older than what the robot was told

_UNCLEAR = (Motion.UNKNOWN, Motion.STOPPING)  # what comes next is not to be seen
_AT_REST = (Motion.STANDING, Motion.ARRIVED, Motion.DOCKED, *_UNCLEAR)


class Knowledge(Enum):
    """How the end of the command will be known."""

    NOTHING = 'no goal was sent'
    AWAITED = 'the controller will tell how it ends'
    DOUBTFUL = 'it is not known yet whether the robot obeys it'
    WATCHED = 'the robot is on its way; its status will tell'


class RouteFailed(Exception):
    """The route cannot go on; `reason` is for the fleet manager, `detail` for people here."""

    def __init__(self, reason: Reason, detail: str = '') -> None:
        super().__init__(reason, detail)
        self.reason = reason
        self.detail = detail

    def __str__(self) -> str:
        return f'{self.reason.text.rstrip(".")}. {self.detail}'.rstrip()


class TakenOver(RouteFailed):
    """The robot obeys another giver already, so that it is not ours to stop."""

    def __init__(self, how: str) -> None:
        super().__init__(TAKEN_OVER, how)


class GoalTracker:
    """The last goal, from the command to the arrival."""

    def __init__(self) -> None:
        self.goals = OwnGoals()
        self.reached = False
        """Whether the robot has said that it is there."""
        self.knowledge = Knowledge.NOTHING
        self.command = ''
        self.number: Optional[int] = None  # of the command whose end is to come
        self.give_again = False
        """Whether the command did not reach the robot."""
        self.failure: Optional[RouteFailed] = None
        """What the robot did with the command instead of obeying it."""
        self.rested_at_goal = 0
        """So many locations in a row, after it said that it is there, show the robot unmoved."""
        # The last status before the command; None where it says nothing, as after a stop since.
        self._before: Optional[RobotSeen] = None
        self._last: Optional[RobotSeen] = None
        self._place: Optional[Tuple[float, float]] = None
        self._place_before: Optional[Tuple[float, float]] = None
        self._doubted_at = -math.inf
        self._interruption: Optional[Tuple[float, str]] = None
        self._never_sent = False
        self._strange_since: Optional[float] = None  # since then each status contradicts the goal

    @property
    def goal(self) -> Optional[str]:
        """Name of the goal last sent; DOCK for the dock, None when we have sent it nowhere."""
        return self.goals.current

    @property
    def has_docked(self) -> bool:
        """Whether the robot has said that it is docked, because we sent it there."""
        return self.goal == DOCK and self.reached

    @property
    def is_doubtful(self) -> bool:
        """Whether it is not known if the robot obeys the last command, or why it no longer does."""
        return self.knowledge is Knowledge.DOUBTFUL or self._interruption is not None

    # --- what we do ------------------------------------------------------------------------------

    def send(self, goal: str, command: str, via: Iterable[str] = ()) -> None:
        """The robot is to go to `goal` (a goal's name, or DOCK), over the goals `via`."""
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
        """Before a restart of this program the robot was sent to `goal`: see whether it goes."""
        self.goals.resume(goal)
        self._reset()
        if goal is not None:
            self._doubt(now)

    def forget(self) -> None:
        """What ended the last route does not count any more."""
        self.failure = self._interruption = None

    def end(self) -> None:
        """We have no more business with the robot."""
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

    # --- what becomes of it ----------------------------------------------------------------------

    def ended(self, event: CommandEnded, now: float) -> None:
        """A command has ended; only the last one counts."""
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
        """The robot was seen at a place (m); one that still goes was seen before it arrived."""
        stands = (motion is not Motion.GOING and self._place is not None
                  and math.dist(self._place, place) <= UNMOVED)
        self._place = place
        if self.reached:
            self.rested_at_goal = self.rested_at_goal + 1 if stands else 0

    def seen(self, status: RobotSeen, now: float, link_stands_since: float) -> None:
        """The robot's status; `link_stands_since` is infinite while no command can reach it."""
        self._last = status
        if status.motion is Motion.STOPPING and not self._is_as_before(status):
            self._before = None
        self.goals.seen(status, self.knowledge is Knowledge.AWAITED)
        if self.knowledge is Knowledge.DOUBTFUL:
            self._resolve(status, now, link_stands_since)
        elif self.knowledge is Knowledge.WATCHED:
            self._watch(status, now)

    def interrupted(self, now: float, words: str) -> None:
        """The robot does something else, perhaps for an emergency stop that is told next."""
        self.give_again = False
        self._interruption = self._interruption or (now, words)

    def goes_on(self, now: float) -> None:
        """No other giver did anything: a drive that was refused for its epoch can be given
        again."""
        if self._never_sent and self._interruption is not None:
            self._interruption = None
            self._doubt(now)

    def check_clock(self, now: float) -> None:
        """An interruption whose cause was not told in time was another giver's doing."""
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
        """Finds out what became of a command whose end was lost."""
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
        """Takes the robot's status for the end of the command that no other message will tell."""
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
        """The robot does something else: for an instant that may be, for longer it is not ours.

        A goal that is neither ours nor shown since before our command is another giver's at once.
        """
        shown_before = self._before is not None and self._before.goal == status.goal
        foreign = (status.motion is Motion.GOING and status.goal not in self.goals
                   and not shown_before)
        if self._strange_since is None:
            self._strange_since = now
        if foreign or now - self._strange_since >= STATUS_LAG:
            self.failure = TakenOver(_what_it_does(status))

    def _is_as_before(self, status: RobotSeen) -> bool:
        """Whether the robot does what it did before the command, so that it never heard it."""
        if self.goals.is_earlier_obeyed(status):
            return True
        before, now = self._place_before, self._place
        return (self._before is not None and _rests_as(self._before, status)
                and before is not None and now is not None
                and math.dist(before, now) <= UNMOVED)


def _rests_as(before: RobotSeen, status: RobotSeen) -> bool:
    """Whether the robot rests as it did `before`: one that was stopped meanwhile says so."""
    if before.motion in _UNCLEAR:
        return status.motion in _AT_REST
    return before.motion in _AT_REST and status.motion in (before.motion, Motion.UNKNOWN)


def _what_it_does(status: RobotSeen) -> str:
    if status.motion is Motion.GOING:
        return f'The robot is going to {status.goal or "another place"}.'
    return f'The robot is {status.motion.value} {status.goal}'.rstrip() + '.'
