"""The rules of work at stops: what each event changes, and what may begin.

A step is stored as RUNNING, under a new key, before it is ordered. It is repeated, under another
key, only in three cases: it is known to have ended without being done, or a person wants it, or it
is harmless. If it is not known whether a step has been done, a person is asked. While a step waits
for an answer, no other step begins.

When a step that takes or gives a load is ordered, the load of the robot counts as unknown until it
is known how the step has ended. So the stored load is right even if the master ends at any moment.
"""
from __future__ import annotations

from dataclasses import replace
from enum import Enum, IntEnum
from math import nan
from typing import FrozenSet, Iterator, List, NamedTuple, Optional, Tuple

from fleet_core.work.stops import (
    Condition,
    LoadEffect,
    Policy,
    StepBlocking,
    When,
    WorkStep,
    WorkStop,
)
from fleet_core.work.tables import (
    LOAD,
    STEP,
    STOP,
    LoadEvent,
    LoadState,
    StepEvent,
    StepState,
    StopEvent,
    StopState,
    after,
)
from fleet_core.work.work import (
    ANY_LOAD,
    Ending,
    RobotLoad,
    Seen,
    Situation,
    StepPlace,
    StepProgress,
    StopProgress,
    Work,
    progress_of,
)
from route_protocol.steps import ShownStep, StepAct, StepCommand, StepReport, Word

GRACE = 10_000  # ms after the command to end a step: if it still runs then, a person is asked


class StepDecision(IntEnum):
    """The answer of a person to a step that asks, as in itrci_nav_msgs/MissionCommand."""

    NONE = 0
    RETRY = 1
    SKIP = 2
    FAIL = 3
    DONE = 4


class Where(NamedTuple):
    """What is known of the robot of a mission.

    stands   -- it stands, and no order that lets it drive is on its way
    is_there -- it stands at the present stop
    is_near  -- it stands at the present stop, or in front of it
    may_enter -- it may drive to the stop now; False: it must wait for its turn at the station
    """

    stands: bool = False
    is_there: bool = False
    is_near: bool = False
    may_enter: bool = True


class WorkPhase(Enum):
    """The state of a mission with steps, as it follows from its work and its robot's load."""

    ACTIVE = 'active'
    CANCELLING = 'cancelling'
    NEEDS_PERSON = 'needs a person'
    SUCCEEDED = 'succeeded'
    FAILED = 'failed'
    CANCELLED = 'cancelled'


# -- derived answers ------------------------------------------------------------------------------


def phase_of(situation: Situation) -> WorkPhase:
    """Returns the state of the mission."""
    work, ending = situation.work, situation.work.ending
    if work.asking is not None:
        return WorkPhase.NEEDS_PERSON
    is_over = work.current == len(work.progress) and not any(open_steps(work))
    if ending is Ending.NONE:
        return WorkPhase.SUCCEEDED if is_over else WorkPhase.ACTIVE
    if any(open_steps(work)):
        return WorkPhase.CANCELLING
    if ending is Ending.FAIL:
        return WorkPhase.FAILED
    if not work.is_cut or is_over:
        if situation.load.is_bound_to(situation.serial):
            return WorkPhase.NEEDS_PERSON
        return WorkPhase.CANCELLED if is_over else WorkPhase.CANCELLING
    return WorkPhase.CANCELLING


def gate_is_closed(work: Work) -> bool:
    """Returns whether the robot must stand because of its work."""
    if any(own.state is StepState.ASK or own.state is StepState.RUNNING
           and step.blocking is not StepBlocking.NONE for _, step, own in work.steps):
        return True
    return work.is_ending or is_at_work(work) and any(
        own.state is StepState.WAITING for own in work.progress[work.current].steps)


def place_not_to_enter(work: Work) -> Optional[int]:
    """Returns the vertex that the robot must not enter before some steps have ended.

    None: there is none.
    """
    number = work.current
    if number == len(work.progress) or is_at_work(work):
        return None
    waits = any(step.when is When.BEFORE_ENTRY and not own.state.is_final
                for place, step, own in work.steps if place.stop == number)
    return work.stops[number].place if waits else None


def time_left(work: Work, now: int) -> float:
    """Returns the seconds until the timeouts of all running steps have passed; NaN: no step runs.

    `now`: ms since 1970.
    """
    ends = [own.begun / 1000.0 + step.timeout for _, step, own in work.steps
            if own.state is StepState.RUNNING]
    return max(max(ends) - now / 1000.0, 0.0) if ends else nan


def open_steps(work: Work) -> Iterator[StepProgress]:
    """Returns the steps that have been ordered and have not ended."""
    return (own for _, _, own in work.steps if own.state in (StepState.RUNNING, StepState.ASK))


def is_at_work(work: Work) -> bool:
    """Returns whether the robot stands at its stop, whose work has not ended."""
    number = work.current
    return number < len(work.progress) and work.progress[number].state is StopState.AT_WORK


# -- guards of a beginning step -------------------------------------------------------------------


def nobody_is_asked(work: Work) -> bool:
    """Returns whether no step waits for an answer."""
    return work.asking is None


def stands_for(step: WorkStep, where: Where) -> bool:
    """Returns whether the robot stands where this step needs it."""
    if step.when is When.BEFORE_ENTRY:
        return step.blocking is StepBlocking.NONE or where.is_there or (
            where.is_near and where.may_enter)
    return where.is_there


def blocks_none(step: WorkStep, work: Work) -> bool:
    """Returns whether this step may run together with all steps that run now."""
    running = [other for _, other, own in work.steps if own.state is StepState.RUNNING]
    return not running or step.blocking is not StepBlocking.HARD and all(
        other.blocking is not StepBlocking.HARD for other in running)


def _has_stop(work: Work) -> bool:
    """Returns whether a stop is left at which steps may run.

    If the mission ends early, there is such a stop only after its work has been cut (`is_cut`).
    """
    return work.current < len(work.progress) and not work.is_ending


def due_step(situation: Situation, where: Where) -> Optional[StepPlace]:
    """Returns the step that is to begin now; None: no step."""
    work = situation.work
    if work.is_ending or not nobody_is_asked(work):
        return None
    for place, step, own in (*_steps_left_behind(work), *_steps_in_turn(work)):
        if own.state is StepState.WAITING:
            is_there = place.stop < work.current or stands_for(step, where)
            return place if is_there and blocks_none(step, work) else None
    return None


def _steps_left_behind(work: Work) -> Iterator[Tuple[StepPlace, WorkStep, StepProgress]]:
    """Returns the steps of earlier stops. Such a step ran on while the robot drove away. So if the
    step is repeated, it begins wherever the robot is.
    """
    return ((place, step, own) for place, step, own in work.steps if place.stop < work.current)


def _steps_in_turn(work: Work) -> Iterator[Tuple[StepPlace, WorkStep, StepProgress]]:
    """Yields, in their order, the steps of the present stop whose turn has come.

    The steps before leaving may begin when all steps at the stop have ended.
    """
    phases = (When.AT, When.BEFORE_LEAVING) if is_at_work(work) else (When.BEFORE_ENTRY,)
    for when in phases:
        some = [(place, step, own) for place, step, own in work.steps
                if place.stop == work.current and step.when is when]
        yield from some
        if not all(own.state.is_final for _, _, own in some):
            return


# -- stops ----------------------------------------------------------------------------------------


def passed(situation: Situation, reached: int) -> Situation:
    """Returns the situation after the robot has passed the first `reached` stops.

    One of these stops may be AT_WORK, because it was the last stop until others were added. The
    robot has left this stop, too.
    """
    work = situation.work
    while work.current < min(reached, len(work.progress)):
        is_there = work.progress[work.current].state is StopState.AT_WORK
        work = _stop(work, StopEvent.LEAVE if is_there else StopEvent.PASS)
    return situation._replace(work=work)


def follow(situation: Situation, where: Where) -> Situation:
    """Returns the situation after the robot has moved, or steps have ended.

    where -- relative to the stop that is present before the call
    """
    work = situation.work
    if where.stands:
        work = _moved(work, where)  # also if the mission is ending
    if _has_stop(work):
        work = _followed(work, where)
    return settle(situation._replace(work=work))


def _followed(work: Work, where: Where) -> Work:
    """Returns the work after its present stop has begun or ended, if either has happened."""
    number = work.current
    if work.progress[number].state is StopState.WAITING:
        work = _stop(work, StopEvent.GO)
    if where.is_there and work.progress[number].state is StopState.DRIVING and (
            _is_made(work, number) and place_not_to_enter(work) is None):
        work = _stop(work, StopEvent.ARRIVE)
    if _may_leave(work) and is_at_work(work):
        return _stop(work, StopEvent.LEAVE)
    if _may_leave(work) and _was_at_work(work):
        return _stop(work, StopEvent.PASS)
    return work


def parted(work: Work) -> Work:
    """Returns the work of a mission that its robot does not serve any more.

    None of the mission's steps was ordered, so another robot begins the mission.
    """
    number = work.current
    is_behind = number < len(work.progress) and work.progress[number].state in (
        StopState.DRIVING, StopState.AT_WORK)
    return _stop(work, StopEvent.PART) if is_behind else work


def _stop(work: Work, event: StopEvent) -> Work:
    stop = work.progress[work.current]
    return work.with_stop(work.current, replace(stop, state=after(STOP, stop.state, event)))


def _is_made(work: Work, number: int) -> bool:
    """Returns whether the robot comes to rest at a stop."""
    return bool(work.stops[number].steps) or number == len(work.stops) - 1


def _may_leave(work: Work) -> bool:
    """Returns whether the present stop has ended.

    The last stop ends when all steps of the mission have ended.
    """
    number = work.current
    is_last = number == len(work.progress) - 1
    return all(own.state.is_final or not is_last and own.state is StepState.RUNNING
               and step.blocking is StepBlocking.NONE
               for place, step, own in work.steps if is_last or place.stop == number)


def _was_at_work(work: Work) -> bool:
    """Returns whether a step of the present stop was ordered there. If so, but the stop is not
    AT_WORK, its robot was moved away.
    """
    number = work.current
    return any(own.times_ordered and step.when is not When.BEFORE_ENTRY
               for place, step, own in work.steps if place.stop == number)


def _moved(work: Work, where: Where) -> Work:
    """Returns the work after the robot was moved away from its stop; if it was not, the same work.

    A person is asked about the steps that run. After that, the robot drives back if its stop has
    steps left.
    """
    if where.is_there or work.current == len(work.progress) or (
            where.is_near and not is_at_work(work)):
        return work
    for place, step, own in work.steps:
        if own.state is StepState.RUNNING and step.blocking is not StepBlocking.NONE:
            work = work.with_step(place, replace(
                own, state=after(STEP, own.state, StepEvent.ASK), is_ended=True,
                text='the robot was moved away meanwhile'))
    return _stop(work, StopEvent.MOVED) if is_at_work(work) else work


# -- steps ----------------------------------------------------------------------------------------


def next_key(work: Work, last: int, now: int) -> int:
    """Returns the key for the next order of a step: above all keys of this mission.

    last -- the highest key that the robot or device of the step has taken
    now  -- ms since 1970; the clock may have been set back
    """
    return max(now, last + 1, *(own.key + 1 for _, _, own in work.steps))


def begin(situation: Situation, place: StepPlace, key: int, run: int, now: int) -> Situation:
    """Returns the situation after a step is ordered under a new key. `now`: ms since 1970."""
    work, load = situation.work, situation.load
    step, own = work.step(place), work.progress_of(place)
    if step.load:
        load = replace(_changing(load, step), serial=situation.serial)
    has_driver = step.actor.has_driver
    return situation._replace(load=load, work=work.with_step(place, StepProgress(
        after(STEP, own.state, StepEvent.SEND), key, run if has_driver else 0, now,
        own.times_ordered + 1, Seen.NOTHING if has_driver else Seen.OVER)))


def _changing(load: RobotLoad, step: WorkStep) -> RobotLoad:
    """Returns the load of a robot after a step that takes or gives a load has begun.

    Until it is known how the step has ended, the robot may carry what it carried before, and also
    what the step takes.
    """
    taken = (step.load_type or ANY_LOAD,) if step.load is LoadEffect.TAKES else ()
    changing = load.with_types(taken)
    return replace(changing, state=after(LOAD, load.state, LoadEvent.BEGIN))


def heard(situation: Situation, report: StepReport, device: str = '') -> Situation:
    """Returns the situation after a report of the robot, or of a device."""
    subject = f'device {device}' if device else 'the robot'
    for place, step, own in tuple(situation.work.steps):
        if step.device != device or own.state not in (StepState.RUNNING, StepState.ASK) or (
                own.seen is Seen.OVER or is_of_an_earlier_run(report, own)):
            continue
        if report.run != own.run:
            situation = _lost(situation, place, f'the driver of {subject} has restarted')
            continue
        shown = report.find(own.key)
        if shown is not None:
            situation = _shown(situation, place, shown, subject)
        elif report.last >= own.key:
            situation = _lost(situation, place, f'{subject} has forgotten it')
    return settle(situation)


def is_of_an_earlier_run(report: StepReport, own: StepProgress) -> bool:
    """Returns whether this report is older than the order of a step."""
    return report.run < own.run


def _shown(situation: Situation, place: StepPlace, shown: ShownStep, subject: str) -> Situation:
    own = situation.work.progress_of(place)
    if not shown.word.is_final:
        seen = replace(own, seen=Seen.RUNNING)
        return situation._replace(work=situation.work.with_step(place, seen))
    situation = _update(situation, place, seen=Seen.OVER)
    if shown.word is Word.DONE:
        return _done(situation, place)
    if shown.word is Word.UNKNOWN:
        return _unknown(situation, place, shown.text or f'{subject} does not know how it ended')
    return _failed(situation, place, shown.text or f'{subject} says {shown.word.name}')


def _lost(situation: Situation, place: StepPlace, text: str) -> Situation:
    return _unknown(_update(situation, place, seen=Seen.OVER), place, text)


def _update(situation: Situation, place: StepPlace, **changes: object) -> Situation:
    own = replace(situation.work.progress_of(place), **changes)  # type: ignore[arg-type]
    return situation._replace(work=situation.work.with_step(place, own))


def _event(situation: Situation, place: StepPlace, event: StepEvent, text: str = '') -> Situation:
    state = after(STEP, situation.work.progress_of(place).state, event)
    return _update(situation, place, state=state, text=text)


def _done(situation: Situation, place: StepPlace) -> Situation:
    effect, load = situation.work.step(place).load, situation.load
    change = {LoadEffect.NONE: 0, LoadEffect.TAKES: 1, LoadEffect.GIVES: -1}[effect]
    if effect and load.state is not LoadState.UNKNOWN:  # a person did the failed step
        situation = situation._replace(load=_changing(load, situation.work.step(place)))
    return _known(_event(situation, place, StepEvent.DONE), place, change)


def _known(situation: Situation, place: StepPlace, change: int = 0) -> Situation:
    """Returns the situation when it is known how a step has changed the load."""
    load = situation.load
    if not situation.work.step(place).load or load.state is not LoadState.UNKNOWN:
        return situation
    count = max(load.count + change, 0)
    event = LoadEvent.FILLED if count else LoadEvent.EMPTIED
    return situation._replace(load=RobotLoad(after(LOAD, load.state, event),
                                             situation.serial if count else 0, count,
                                             load.types if count else None))


def _failed(situation: Situation, place: StepPlace, text: str) -> Situation:
    """Returns the situation when a step is known to have ended without being done.

    The policy of the step decides what follows.
    """
    situation = _known(situation, place)
    work, step = situation.work, situation.work.step(place)
    own = work.progress_of(place)
    if work.is_ending:
        return _event(situation, place, StepEvent.CANCEL, text)
    if own.state is StepState.ASK:
        return _update(situation, place, text=text)
    if step.on_failure is Policy.RETRY and own.times_ordered <= step.retries:
        return _event(situation, place, StepEvent.RETRY, text)
    if step.on_failure is Policy.SKIP:
        return _event(situation, place, StepEvent.FAIL, text)
    if step.on_failure is Policy.FAIL:
        return _end(_event(situation, place, StepEvent.FAIL, text), Ending.FAIL,
                    f'step {step.type} has failed: {text}')
    return _event(situation, place, StepEvent.ASK, text)


def _unknown(situation: Situation, place: StepPlace, text: str) -> Situation:
    """Returns the situation when it is not known whether a step has been done.

    A person is asked, unless the step is harmless and may be repeated.
    """
    work, step = situation.work, situation.work.step(place)
    own = work.progress_of(place)
    if work.is_ending:
        return _event(situation, place, StepEvent.CANCEL, text)
    if may_be_repeated(step, own):
        return _event(situation, place, StepEvent.RETRY, text)
    if own.state is StepState.ASK:
        return _update(situation, place, text=text)
    return _event(situation, place, StepEvent.ASK, text)


def may_be_repeated(step: WorkStep, own: StepProgress) -> bool:
    """Returns whether a step may be repeated although it is not known whether it has been done."""
    return step.harmless and own.state is StepState.RUNNING and (
        own.times_ordered <= max(step.retries, 1))


def expire(situation: Situation, now: int) -> Situation:
    """Returns the situation after the timeouts that are over at `now` (ms since 1970)."""
    for place, step, own in tuple(situation.work.steps):
        over = own.begun + round(1000.0 * step.timeout)
        if own.state is not StepState.RUNNING or now < over:
            continue
        if step.breakable and step.actor.has_driver and now < over + GRACE:
            if not own.is_ended:
                situation = _update(situation, place, is_ended=True)
            continue
        situation = _event(_update(situation, place, is_ended=True), place, StepEvent.ASK,
                           f'it has not ended within {step.timeout:.0f} s')
    return settle(situation)


def answer(situation: Situation, said: StepDecision, key: int = 0) -> Tuple[Situation, str]:
    """Returns the situation after a person's answer, and a clause that says why the answer is
    refused (empty: it is accepted).

    key -- key of the step that is answered; 0: the step that is `answerable`
    """
    work, place = situation.work, situation.work.answerable
    if place is None or key and work.progress_of(place).key != key:
        return situation, 'no such step waits for an answer'
    step, own = work.step(place), work.progress_of(place)
    problem = _no_answer(work, own, said)
    if problem:
        return situation, f'step {step.type} {problem}'
    situation = _update(situation, place, seen=Seen.OVER)
    if said is StepDecision.DONE:
        situation = _done(situation, place)
    elif said is StepDecision.RETRY:
        situation = _event(_known(situation, place), place, StepEvent.RETRY)
    elif said is StepDecision.SKIP:
        situation = _event(_known(situation, place), place, StepEvent.CANCEL, 'skipped')
    elif own.state is StepState.RUNNING:
        situation = _failed(situation, place, 'it failed, as answered')
    else:
        situation = _end(_event(situation, place, StepEvent.FAIL, own.text), Ending.FAIL,
                         f'step {step.type} has failed: {own.text}')
    return settle(situation), ''


def _no_answer(work: Work, own: StepProgress, said: StepDecision) -> str:
    """Returns why a person cannot give this answer to the step; '': the answer is possible.

    The text continues a sentence that begins with the name of the step.
    """
    if said is StepDecision.RETRY and own.state is StepState.RUNNING:
        return 'runs: there is nothing to retry'
    if said is StepDecision.RETRY and work.is_ending:
        return 'is not repeated, because its mission ends'
    if own.seen is Seen.NOTHING:
        return ('is still on its way to its robot or device: start the driver of the robot or '
                'device, and answer when it shows the step')
    if said is StepDecision.RETRY and not has_ended(own):
        return 'still runs: wait until it ends'
    return ''


def has_ended(own: StepProgress) -> bool:
    """Returns whether it is known that the last order of this step is not carried out any more."""
    return own.seen is Seen.OVER


# -- the end of a mission -------------------------------------------------------------------------


def cancel(situation: Situation, reason: str = '') -> Situation:
    """Returns the situation after the mission is cancelled, which is possible in every state."""
    return settle(_end(situation, Ending.CANCEL, reason))


def fail(situation: Situation, reason: str) -> Situation:
    """Returns the situation of a mission when neither its stops nor the stops of `on_cancel` can be
    made any more.
    """
    return settle(situation._replace(work=replace(
        situation.work, ending=Ending.FAIL, is_cut=False, reason=reason)))


def _end(situation: Situation, ending: Ending, reason: str) -> Situation:
    """Returns the situation of a mission that ends.

    A mission that fails while it makes its stops of `on_cancel` counts as failed.
    """
    before = situation.work.ending
    if ending is before or before is Ending.FAIL or situation.work.is_ending:
        return situation
    return situation._replace(work=replace(situation.work, ending=ending, is_cut=False,
                                           reason=reason))


def settle(situation: Situation) -> Situation:
    """Returns the situation of an ending mission, after each part that can end now has ended."""
    if not situation.work.is_ending:
        return situation
    for place, _, own in tuple(situation.work.steps):
        is_open = own.state is StepState.RUNNING or own.state is StepState.ASK
        if own.state is StepState.WAITING:
            situation = _event(situation, place, StepEvent.CANCEL, own.text)
        elif is_open and own.seen is not Seen.OVER:
            situation = _update(situation, place, is_ended=True)
        elif is_open:  # a person must say where the load of the step is
            situation = _event(situation, place, StepEvent.CANCEL, own.text)
    work = situation.work
    if any(open_steps(work)):
        return situation
    if work.ending is Ending.FAIL:
        return situation._replace(work=_cut(work, StopEvent.FAIL))
    if situation.load.is_bound_to(situation.serial) and (
            situation.load.state is LoadState.UNKNOWN):
        return situation
    return situation._replace(work=_with_clean_up(_cut(work, StopEvent.SKIP), situation))


def _cut(work: Work, event: StopEvent) -> Work:
    """Returns the work without the stops that have not begun. A stop that has begun is ended."""
    number = work.current
    if number == len(work.progress):
        return work
    state = work.progress[number].state
    if state is StopState.WAITING or event is StopEvent.SKIP and not has_begun(
            work.progress[number]):
        return replace(work, stops=work.stops[:number], progress=work.progress[:number])
    work = _stop(work, event)
    return replace(work, stops=work.stops[:number + 1], progress=work.progress[:number + 1])


def _with_clean_up(work: Work, situation: Situation) -> Work:
    is_loaded = situation.load.is_bound_to(situation.serial)
    wanted = {Condition.ALWAYS, Condition.LOADED if is_loaded else Condition.EMPTY}
    stops = tuple(stop for stop in work.on_cancel if stop.condition in wanted)
    return replace(work, stops=(*work.stops, *stops), is_cut=True,
                   progress=(*work.progress, *map(progress_of, stops)))


# -- other stops ----------------------------------------------------------------------------------


def changed(situation: Situation, stops: Tuple[WorkStop, ...], first: int = 0,
            ) -> Tuple[Situation, str]:
    """Returns the situation after new stops have replaced stops that have not begun, and a clause
    that says why the change is refused (empty: it is made).

    first -- number, from 1, of the first stop to be replaced; 0: the first one that has not begun
    """
    work = situation.work
    if work.ending is not Ending.NONE:
        return situation, f'it ends already: {work.reason}'
    number = work.current
    begun = number + (number < len(work.progress) and has_begun(work.progress[number]))
    kept = first - 1 if first else begun
    if kept < begun:
        return situation, f'stop {first} has begun'
    if kept > len(work.stops):
        return situation, f'it has {len(work.stops)} stops, and none of number {first}'
    return situation._replace(work=replace(
        work, stops=(*work.stops[:kept], *stops),
        progress=(*work.progress[:kept], *map(progress_of, stops)))), ''


def chosen(situation: Situation, place: int) -> Situation:
    """Returns the situation after another place of the group is chosen for the present stop."""
    work = situation.work
    stops = list(work.stops)
    stops[work.current] = replace(stops[work.current], place=place)
    return situation._replace(work=replace(work, stops=tuple(stops)))


def has_begun(stop: StopProgress) -> bool:
    """Returns whether the robot is at work at a stop, or one of its steps was ordered."""
    return stop.state is StopState.AT_WORK or any(own.times_ordered for own in stop.steps)


# -- the load, as a person says -------------------------------------------------------------------


def said_empty(load: RobotLoad) -> RobotLoad:
    """Returns the load of a robot after a person says that it carries nothing."""
    return RobotLoad(after(LOAD, load.state, LoadEvent.SAID_EMPTY))


def said_loaded(load: RobotLoad, serial: int, work: Optional[Work] = None) -> RobotLoad:
    """Returns the load after a person says that the robot carries the load of this mission.

    If the robot counted as empty, its load may be any load that the mission takes.

    work -- the work of the mission; None: the mission has no steps
    """
    types = load.may_be or {step.load_type or ANY_LOAD for _, step, _ in (
        () if work is None else work.steps) if step.load is LoadEffect.TAKES}
    return RobotLoad(after(LOAD, load.state, LoadEvent.SAID_LOADED), serial, max(load.count, 1),
                     tuple(sorted(types or (ANY_LOAD,))))


def to_take(work: Work) -> FrozenSet[str]:
    """Returns the types of load that a robot has yet to take at its present or next stop."""
    number = work.current
    if work.is_ending or number == len(work.stops):
        return frozenset()
    stop = zip(work.stops[number].steps, work.progress[number].steps)
    return frozenset(step.load_type or ANY_LOAD for step, own in stop
                     if step.load is LoadEffect.TAKES and not own.state.is_final)


# -- commands to the robot and to devices ---------------------------------------------------------


def commands(work: Work, report: StepReport, device: str = '') -> List[StepCommand]:
    """Returns the commands to the robot or to a device that the report does not show yet.

    `work` must be stored already. A key is sent only when the report shows all lower keys.
    """
    found: List[StepCommand] = []
    for step, own in _to_be_told(work, report, device):
        shown = report.find(own.key)
        if shown is None:
            return [*found, _first_command(step, own)]
        if own.is_ended and step.breakable and not shown.word.is_final:
            found.append(StepCommand(own.key, StepAct.CANCEL, own.run))
    return found


def _to_be_told(work: Work, report: StepReport,
                device: str) -> List[Tuple[WorkStep, StepProgress]]:
    """Returns the steps about which an actor may need a command, in the order of their keys."""
    steps = [(step, own) for _, step, own in work.steps if step.actor.has_driver
             and step.device == device and own.state in (StepState.RUNNING, StepState.ASK)
             and own.seen is not Seen.OVER and own.run == report.run]
    return sorted(steps, key=lambda pair: pair[1].key)


def _first_command(step: WorkStep, own: StepProgress) -> StepCommand:
    """Returns the command to an actor that does not show a step yet: to begin it, or never to
    begin it.
    """
    if own.is_ended:
        act = StepAct.CANCEL if step.breakable else StepAct.REVOKE
        return StepCommand(own.key, act, own.run, timeout=step.timeout)
    return StepCommand(own.key, StepAct.DO, own.run, step.type, step.parameters, step.timeout)
