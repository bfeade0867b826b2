"""What the robot's reported activity says about a drive or stop that is under way.

When a drive ends, the robot does not always name the drive. If another client stops the robot, the
robot may say no more than `Stopping`, `Stopped`, or it may name a point instead of the goal.
Therefore every line and status about the robot's activity is compared with each command under way.
A single contradiction does not end the command: right after a command the status may be out of
date, or be `Stopping` or `Stopped` for an instant (observed). No line distinguishes such a status
from a real end; only the duration of the contradiction does. So an activity that contradicts a
command begins a doubt, and a doubt that lasts ends the command; see `drives`.

The module consists of tables and pure functions. Until a drive is acknowledged, the rows of
JUDGEMENTS with `begun` True do not apply to it.
"""
from __future__ import annotations

from dataclasses import replace
from enum import Enum
from typing import Callable, Dict, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

from omron_arcl.activity import MOVING, STANDING, Activity, ActivityKind
from omron_arcl.commands import DriveCourse, Predicate
from omron_arcl.execution import Execution, Outcome
from omron_arcl.records import Doubt
from omron_arcl.replies import Reply, coordinates

# s from the first contradiction until the command ends, if there were at least two contradictions
SETTLE: Mapping[DriveCourse, float] = {
    DriveCourse.TO_A_PLACE: 4.0,
    DriveCourse.INTO_THE_DOCK: 30.0,  # between two attempts the robot stands and is undocked
    DriveCourse.OUT_OF_THE_DOCK: 10.0,
    DriveCourse.OF_TASKS: 30.0,  # between two steps the robot may stand
}
SETTLE_CERTAIN = 4.0  # s, instead of SETTLE for an arrival or an emergency stop
SETTLE_STOP = 2.0  # s of standing after which a stop without `Stopped` counts as obeyed
SETTLE_OVERTAKEN = 6.0  # s of driving elsewhere after which a stop counts as overtaken
SETTLE_ONCE = 5.0  # s, added if there was only one contradiction: the robot may send no status

# In these activities a robot may begin a drive before it names the goal: it leaves its dock for the
# drive, or drives to the dock.
ABOUT_THE_DOCK = frozenset((ActivityKind.UNDOCKING, ActivityKind.DOCKING))


class DriveSign(Enum):
    """What an activity says about a command that it does not end."""

    CONFIRMED = 'it is being carried out'
    NONE = 'nothing'


Verdict = Union[DriveSign, Outcome]


class Observation(NamedTuple):
    """An activity that the robot reports, in a status or in a line sent when it changes.

    asked -- the number, in the order of sending, of the query that a status answers; None: the
        robot sent the activity unasked
    """

    activity: Activity
    text: str
    is_status: bool
    asked: Optional[int] = None

    @property
    def words(self) -> str:
        """The words that describe the activity to the giver of the command."""
        return f'the robot\'s status is "{self.text}"' if self.is_status else self.text

    def is_line_of(self, kind: ActivityKind) -> bool:
        """Returns whether this is an activity of this kind, reported in a line, not in a status."""
        return self.activity.kind is kind and not self.is_status

    @property
    def point(self) -> Tuple[float, ...]:
        """The coordinates that the robot shows as its goal."""
        return coordinates(getattr(self.activity.reply, 'goal', ''))


_K = ActivityKind
_STANDS_OR_DRIVES_ELSEWHERE: Dict[ActivityKind, Verdict] = {
    **dict.fromkeys((
        _K.STOPPED, _K.STOPPING, _K.ARRIVED_AT_GOAL, _K.ARRIVED_AT_POINT, _K.INTERRUPTED,
        _K.PARKING, _K.PARKED, _K.TELEOPERATED, _K.PATROLLING, _K.GOING_TO_GOAL,
        _K.GOING_TO_POINT, _K.DOCKING, _K.DOCKED), Outcome.INTERRUPTED),
    _K.FAILED: Outcome.FAILED,
    _K.LOST: Outcome.FAILED,
}
# What an activity means for a drive that has begun, if no row of JUDGEMENTS holds.
VERDICTS: Mapping[DriveCourse, Dict[ActivityKind, Verdict]] = {
    DriveCourse.TO_A_PLACE: {
        **_STANDS_OR_DRIVES_ELSEWHERE, _K.UNDOCKING: DriveSign.CONFIRMED},
    DriveCourse.INTO_THE_DOCK: {
        **_STANDS_OR_DRIVES_ELSEWHERE,
        _K.DOCKING: DriveSign.CONFIRMED, _K.DOCKED: Outcome.SUCCEEDED,
        _K.UNDOCKING: Outcome.INTERRUPTED, _K.UNDOCKED: Outcome.INTERRUPTED},
    DriveCourse.OUT_OF_THE_DOCK: {
        **_STANDS_OR_DRIVES_ELSEWHERE, _K.UNDOCKING: DriveSign.CONFIRMED,
        _K.UNDOCKED: Outcome.SUCCEEDED},
    DriveCourse.OF_TASKS: {
        **dict.fromkeys((
            _K.GOING_TO_GOAL, _K.GOING_TO_POINT, _K.PATROLLING, _K.DOING_TASK, _K.DOCKING,
            _K.UNDOCKING), DriveSign.CONFIRMED),
        **dict.fromkeys((
            _K.STOPPED, _K.INTERRUPTED, _K.TELEOPERATED, _K.PARKING, _K.PARKED),
            Outcome.INTERRUPTED),
        _K.FAILED: Outcome.FAILED, _K.LOST: Outcome.FAILED},
}


class ObservationRule(NamedTuple):
    """A rule for drives: an observation has this verdict if `holds` returns a true value.

    begun -- True: the rule is only for drives that have begun; False: only for drives that have
        not; None: for all drives
    """

    name: str
    verdict: Verdict
    holds: Callable[[Execution, Observation], object]
    begun: Optional[bool] = None


def _to_a_point(execution: Execution, seen: Observation, kind: ActivityKind) -> bool:
    """Returns whether the robot shows coordinates for a drive to a place.

    Some robots show the coordinates of a goal instead of its name (ARCL manual I617-E-02 p. 243).
    If the command itself names a point, only the row `its goal` compares coordinates.
    """
    return (seen.activity.kind is kind and execution.command.spec.course is DriveCourse.TO_A_PLACE
            and bool(execution.command.goals or not seen.point))


# The first row that holds decides. If no row holds, VERDICTS decides.
JUDGEMENTS: Tuple[ObservationRule, ...] = (
    ObservationRule('emergency stop', Outcome.EMERGENCY_STOPPED,
              lambda execution, seen: seen.activity.kind is _K.EMERGENCY_STOP),
    ObservationRule('no power', Outcome.FAILED,
              lambda execution, seen: seen.activity.kind is _K.MOTORS_DISABLED),
    ObservationRule('arrived', Outcome.SUCCEEDED, lambda execution, seen: (
        seen.is_status
        and fits(execution.command.spec.completed_by, execution, seen.activity.reply))),
    ObservationRule('its goal', DriveSign.CONFIRMED,
              lambda execution, seen: acknowledges(execution, seen.activity.reply)),
    ObservationRule('its point', DriveSign.CONFIRMED,
              lambda execution, seen: _to_a_point(execution, seen, _K.GOING_TO_POINT),
              begun=True),
    ObservationRule('at its point', Outcome.SUCCEEDED, lambda execution, seen: (
        _to_a_point(execution, seen, _K.ARRIVED_AT_POINT)
        and seen.point in execution.progress.points), begun=True),
    ObservationRule('broken off', Outcome.INTERRUPTED, lambda execution, seen: (
        execution.progress.set_out and seen.activity.kind is _K.INTERRUPTED), begun=False),
    # the robot drives to its dock before it reports that it docks
    ObservationRule('on its way to the dock', DriveSign.CONFIRMED, lambda execution, seen: (
        execution.command.spec.course is DriveCourse.INTO_THE_DOCK
        and seen.activity.kind in MOVING), begun=False),
    ObservationRule('leaving the dock', DriveSign.CONFIRMED, lambda execution, seen: (
        execution.progress.set_out and seen.activity.kind in ABOUT_THE_DOCK), begun=False),
)


def fits(predicate: Optional[Predicate], execution: Execution, reply: Reply) -> bool:
    """Returns whether a command has this predicate, and the line fulfils it."""
    return predicate is not None and predicate(execution.command, reply)


def acknowledges(execution: Execution, reply: Reply) -> bool:
    """Returns whether a line, or a status with the text of a line, acknowledges a drive."""
    return fits(execution.command.spec.acknowledged_by, execution, reply)


def judge(execution: Execution, seen: Observation, begun: bool, drives: Sequence[Execution]
          ) -> Verdict:
    """Returns what the robot's activity says about a drive or stop that was sent.

    drives -- all drives that were sent
    """
    if seen.asked is not None and seen.asked < execution.order:
        return DriveSign.NONE  # the status answers a query that was sent before the command
    if execution.command.spec.stops:
        return _judge_stop(execution, seen, drives)
    for row in JUDGEMENTS:
        if row.begun in (None, begun) and row.holds(execution, seen):
            return row.verdict
    course = execution.command.spec.course
    if not begun or course is None:
        return DriveSign.NONE
    return VERDICTS[course].get(seen.activity.kind, DriveSign.NONE)


def _judge_stop(stop: Execution, seen: Observation, drives: Sequence[Execution]) -> Verdict:
    """Judges a stop: obeyed if the robot stands, overtaken if the robot drives elsewhere."""
    kind = seen.activity.kind
    if seen.is_status and kind in STANDING:
        return Outcome.SUCCEEDED
    if not seen.is_status or kind not in MOVING:
        return DriveSign.NONE
    before = stop.progress.shown_when_sent
    is_elsewhere = before is not None and seen.activity != before and not any(
        acknowledges(drive, seen.activity.reply) for drive in drives)
    return Outcome.INTERRUPTED if is_elsewhere else DriveSign.CONFIRMED


def next_doubt(doubt: Optional[Doubt], outcome: Outcome, seen: Observation, now: float,
               begun: bool) -> Doubt:
    """Returns the doubt after another activity that contradicts a command."""
    broken_off = (seen.is_line_of(ActivityKind.INTERRUPTED)
                  and (not seen.activity.goal or not begun))
    if doubt is None or (outcome is not doubt.outcome
                         and Outcome.SUCCEEDED in (outcome, doubt.outcome)):
        return Doubt(now, seen.words, outcome, broken_off=broken_off)
    if outcome is not doubt.outcome or broken_off:
        doubt = replace(doubt, outcome=outcome, why=seen.words)
    return replace(doubt, count=doubt.count + 1, broken_off=doubt.broken_off or broken_off)


def is_settled(doubt: Doubt, course: Optional[DriveCourse], now: float) -> bool:
    """Returns whether the doubt about a command has lasted long enough to end that command.

    course -- the course of the drive; None: the command is a stop
    """
    certain: Tuple[Outcome, ...] = (Outcome.SUCCEEDED, Outcome.EMERGENCY_STOPPED)
    if course is None:
        settle = SETTLE_STOP if doubt.outcome is Outcome.SUCCEEDED else SETTLE_OVERTAKEN
    else:
        settle = SETTLE_CERTAIN if doubt.outcome in certain else SETTLE[course]
    lasted = now - doubt.since
    return doubt.is_certain or lasted >= settle + (SETTLE_ONCE if doubt.count == 1 else 0.0)
