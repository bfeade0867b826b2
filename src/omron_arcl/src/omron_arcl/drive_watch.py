"""Decides by the robot's reported activity whether a drive still goes on.

The robot does not always name a drive that ends. If another client stops it, it may say no more
than `Stopping`, `Stopped`, or name a point instead of the goal. Every line and status about the
robot's activity is therefore compared with the drive that it was sent on. An activity that
contradicts the drive for some seconds ends it. One contradiction is not enough: right after a
command the status may be out of date, or be `Stopping`, `Stopped` for an instant (observed). No
line says which of the two it is; only that it lasts shows it. A status that answers an older
question than the command says nothing about the command.

    event                                              not doubted    doubted
    an activity contradicts it                         doubted        counted
    the same, arrived instead of broken off, or the    -              doubted since now
    other way round
    an activity confirms it; it is acknowledged; a     -              not doubted
    stop: the robot still drives as before it
    `Stopped` after `Interrupted` of something unknown -              ended
    SETTLE s with two contradictions, SETTLE_ONCE s    -              ended
    more with one

Invariants: nothing ends a command before it was contradicted for SETTLE s, except that `Stopped`. A
drive that is not acknowledged is judged only by the rules that say so.
"""
from __future__ import annotations

from enum import Enum
from typing import Callable, Dict, Mapping, NamedTuple, Optional, Tuple, Union

from omron_arcl import replies
from omron_arcl.activity import MOVING, STANDING, Activity, ActivityKind
from omron_arcl.command_queue import CommandQueue
from omron_arcl.commands import DriveCourse, Predicate
from omron_arcl.execution import Doubt, Execution, Outcome
from omron_arcl.replies import coordinates

# s after which an activity that contradicted a command at least twice ends it
SETTLE: Mapping[DriveCourse, float] = {
    DriveCourse.TO_A_PLACE: 4.0,
    DriveCourse.INTO_THE_DOCK: 30.0,  # between two attempts the robot stands and is undocked
    DriveCourse.OUT_OF_THE_DOCK: 10.0,
    DriveCourse.OF_TASKS: 30.0,  # between two steps the robot may stand
}
SETTLE_CERTAIN = 4.0  # s, the same for an arrival and for an emergency stop
SETTLE_STOP = 2.0  # s of standing after which a stop without `Stopped` counts as obeyed
SETTLE_OVERTAKEN = 6.0  # s of driving elsewhere after which a stop counts as overtaken
SETTLE_ONCE = 5.0  # s more after a single contradiction: the robot answers no status requests

# Activities of a drive that the robot has not acknowledged by its goal's name yet: the robot leaves
# the dock for the drive, or drives to the dock.
ABOUT_THE_DOCK = frozenset((ActivityKind.UNDOCKING, ActivityKind.DOCKING))


class DriveSign(Enum):
    """What an activity says about a command that it does not end."""

    CONFIRMED = 'it is being carried out'
    NONE = 'nothing'


Verdict = Union[DriveSign, Outcome]

class Observation(NamedTuple):
    """An activity that the robot reports, in a status or in a line sent when it changes.

    asked -- the number, in the order of sending, of the question that a status answers; None: the
        robot sent it unasked
    """

    activity: Activity
    text: str
    is_status: bool
    asked: Optional[int] = None

    @property
    def words(self) -> str:
        """The words for the giver of the command."""
        return f'the robot\'s status is "{self.text}"' if self.is_status else self.text


_K = ActivityKind
_STANDS_OR_DRIVES_ELSEWHERE: Dict[ActivityKind, Verdict] = {
    **dict.fromkeys((
        _K.STOPPED, _K.STOPPING, _K.ARRIVED_AT_GOAL, _K.ARRIVED_AT_POINT, _K.INTERRUPTED,
        _K.PARKING, _K.PARKED, _K.TELEOPERATED, _K.PATROLLING, _K.GOING_TO_GOAL,
        _K.GOING_TO_POINT, _K.DOCKING, _K.DOCKED), Outcome.INTERRUPTED),
    _K.FAILED: Outcome.FAILED,
    _K.LOST: Outcome.FAILED,
}
# The verdict of an activity on a drive that has begun, if no row of JUDGEMENTS holds.
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
    """What an observation says about a drive if `holds`.

    begun -- whether the rule is about a drive that has begun; None: about each drive
    """

    name: str
    verdict: Verdict
    holds: Callable[[Execution, Observation], object]
    begun: Optional[bool] = None


def _point(seen: Observation) -> Tuple[float, ...]:
    return coordinates(getattr(seen.activity.reply, 'goal', ''))


def _to_a_point(execution: Execution, seen: Observation, kind: ActivityKind) -> bool:
    """Whether the robot shows coordinates for a drive to a place.

    Some robots show those of a goal instead of its name (ARCL manual I617-E-02 p. 243). A command
    that names a point itself is confirmed by no other point.
    """
    return (seen.activity.kind is kind and execution.command.spec.course is DriveCourse.TO_A_PLACE
            and bool(execution.command.goals or not _point(seen)))


# The first row that holds decides; without one, VERDICTS does.
JUDGEMENTS: Tuple[ObservationRule, ...] = (
    ObservationRule('emergency stop', Outcome.EMERGENCY_STOPPED,
              lambda execution, seen: seen.activity.kind is _K.EMERGENCY_STOP),
    ObservationRule('no power', Outcome.FAILED,
              lambda execution, seen: seen.activity.kind is _K.MOTORS_DISABLED),
    ObservationRule('arrived', Outcome.SUCCEEDED, lambda execution, seen: (
        seen.is_status and _fits(execution.command.spec.completed_by, execution, seen.activity))),
    ObservationRule('its goal', DriveSign.CONFIRMED,
              lambda execution, seen: _acknowledges(execution, seen.activity)),
    ObservationRule('its point', DriveSign.CONFIRMED,
              lambda execution, seen: _to_a_point(execution, seen, _K.GOING_TO_POINT),
              begun=True),
    ObservationRule('at its point', Outcome.SUCCEEDED, lambda execution, seen: (
        _to_a_point(execution, seen, _K.ARRIVED_AT_POINT)
        and _point(seen) in execution.progress.points), begun=True),
    ObservationRule('broken off', Outcome.INTERRUPTED, lambda execution, seen: (
        execution.progress.set_out and seen.activity.kind is _K.INTERRUPTED), begun=False),
    # the robot drives to its dock before it reports that it docks
    ObservationRule('on its way to the dock', DriveSign.CONFIRMED, lambda execution, seen: (
        execution.command.spec.course is DriveCourse.INTO_THE_DOCK
        and seen.activity.kind in MOVING), begun=False),
    ObservationRule('leaving the dock', DriveSign.CONFIRMED, lambda execution, seen: (
        execution.progress.set_out and seen.activity.kind in ABOUT_THE_DOCK), begun=False),
)


class DriveWatch:
    """Compares the robot's activity with the motions that a queue has sent."""

    def __init__(self, commands: CommandQueue) -> None:
        self._commands = commands

    @property
    def in_doubt(self) -> bool:
        """Whether another status would help to decide on a motion under way."""
        return any(execution.progress.doubt for execution in self._commands.motion_executions)

    def observe(self, seen: Observation, now: float) -> None:
        """Processes an activity that the robot reports."""
        for execution in self._commands.motion_executions:
            if seen.asked is not None and seen.asked < execution.order:
                continue
            if execution.command.spec.stops:
                self._observe_stop(execution, seen, now)
            else:
                self._observe_drive(execution, seen, now)

    def on_time(self, now: float) -> None:
        """Ends the commands that have been contradicted for long enough."""
        for execution in self._commands.motion_executions:
            doubt = execution.progress.doubt
            if doubt is None or execution not in self._commands.sent:  # it ended with another
                continue
            since, settle = now - doubt.since, _settle_time(execution, doubt)
            if since >= settle and (doubt.count > 1 or since >= settle + SETTLE_ONCE):
                self._commands.end(execution, doubt.outcome, doubt.words)

    def _observe_drive(self, execution: Execution, seen: Observation, now: float) -> None:
        kind, progress = seen.activity.kind, execution.progress
        if (kind is ActivityKind.STOPPED and not seen.is_status and progress.doubt
                and progress.doubt.broken_off):
            self._commands.end(execution, Outcome.INTERRUPTED, progress.doubt.words)
            return
        begun = self._commands.records.has_begun(execution)
        verdict = _judge(execution, seen, begun)
        if verdict is DriveSign.CONFIRMED:
            progress.doubt = None
            if kind is ActivityKind.GOING_TO_POINT:
                progress.points.add(_point(seen))
            if seen.is_status:
                progress.heard = now
                if _acknowledges(execution, seen.activity):
                    self._commands.begin(execution)
        elif isinstance(verdict, Outcome):
            _doubt(execution, verdict, seen, now, begun)

    def _observe_stop(self, stop: Execution, seen: Observation, now: float) -> None:
        """A stop is obeyed if the robot stands, and overtaken if the robot drives elsewhere."""
        kind = seen.activity.kind
        if not seen.is_status:
            return
        if kind in STANDING:
            _doubt(stop, Outcome.SUCCEEDED, seen, now)
        elif kind in MOVING and seen.activity != stop.progress.shown_when_sent and not any(
                _acknowledges(drive, seen.activity) for drive in self._commands.drives):
            _doubt(stop, Outcome.INTERRUPTED, seen, now)
        elif kind in MOVING:
            stop.progress.doubt = None


def _judge(execution: Execution, seen: Observation, begun: bool) -> Verdict:
    """The verdict of the robot's activity on a drive."""
    for row in JUDGEMENTS:
        if row.begun in (None, begun) and row.holds(execution, seen):
            return row.verdict
    course = execution.command.spec.course
    if not begun or course is None:
        return DriveSign.NONE
    return VERDICTS[course].get(seen.activity.kind, DriveSign.NONE)


def _acknowledges(execution: Execution, activity: Activity) -> bool:
    return _fits(execution.command.spec.acknowledged_by, execution, activity)


def _fits(predicate: Optional[Predicate], execution: Execution, activity: Activity) -> bool:
    return predicate is not None and predicate(execution.command, activity.reply)


def _doubt(execution: Execution, outcome: Outcome, seen: Observation, now: float,
           begun: bool = True) -> None:
    broken_off = (isinstance(seen.activity.reply, replies.Interrupted) and not seen.is_status
                  and (not seen.activity.goal or not begun))
    doubt = execution.progress.doubt
    if doubt is None or (outcome is not doubt.outcome
                         and Outcome.SUCCEEDED in (outcome, doubt.outcome)):
        execution.progress.doubt = Doubt(outcome, seen.words, now, broken_off=broken_off)
        return
    doubt.count += 1
    doubt.broken_off = doubt.broken_off or broken_off
    if outcome is not doubt.outcome or broken_off:
        doubt.outcome, doubt.words = outcome, seen.words


def _settle_time(execution: Execution, doubt: Doubt) -> float:
    course = execution.command.spec.course
    if course is None:
        return SETTLE_STOP if doubt.outcome is Outcome.SUCCEEDED else SETTLE_OVERTAKEN
    certain: Tuple[Outcome, ...] = (Outcome.SUCCEEDED, Outcome.EMERGENCY_STOPPED)
    return SETTLE_CERTAIN if doubt.outcome in certain else SETTLE[course]
