"""A mission with steps in a small world: every sequence of events, with the real rules and the real
memory of the robot.

The state of the world includes facts that no program knows: the step that is being carried out, how
often each step was carried out, and the load of the robot. Messages may be late, lost, repeated and
reordered: a message may arrive at any time after it was sent, any number of times. The manager may
end between any two events; it then continues from its stored data. The robot's driver may restart:
then it forgets its steps, and a running step may or may not have been carried out.

People look before they answer, so their answers are true.
"""
from __future__ import annotations

import gc
from dataclasses import dataclass, field
from typing import (
    Any,
    Callable,
    Dict,
    FrozenSet,
    Iterator,
    List,
    NamedTuple,
    Optional,
    Set,
    Tuple,
    TypeVar,
)

from fleet_core.work import rules
from fleet_core.work.rules import StepDecision, Where, WorkPhase
from fleet_core.work.stops import Actor, LoadEffect, StepBlocking, When, WorkStep, WorkStop
from fleet_core.work.tables import LoadState
from fleet_core.work.work import Situation, Work, work_of
from route_protocol.steps import ActorState, Reaction, StepCommand, StepReport, Word

SERIAL = 7
AWAY = 0
LATER = 10 ** 9   # ms: at this time all timeouts are over, and also the time for ending steps early
NOT_MUCH_LATER = 1500
NO_WAY = 'no way'
FINAL = {WorkPhase.SUCCEEDED, WorkPhase.FAILED, WorkPhase.CANCELLED}


class Body(NamedTuple):
    """The true progress of one step.

    key   -- the key under which the step is carried out now; 0: it is not carried out now
    times -- how often the step was carried out
    """

    key: int = 0
    is_broken_off: bool = False
    times: int = 0


class State(NamedTuple):
    """The whole world. `memory` is the manager's memory, `disk` the data that it has stored.

    orders -- number of commands given so far to begin a step
    bodies -- the bodies, by the type of the step; each type has only one step
    place  -- vertex at which the robot stands
    """

    memory: Situation
    disk: Situation
    orders: int
    known: Optional[StepReport]
    actor: ActorState
    bodies: Tuple[Tuple[str, Body], ...]
    carried: int
    place: int
    sent: FrozenSet[StepCommand]
    told: Tuple[StepReport, ...]
    left: Tuple[int, ...]

    def body(self, step: str) -> Body:
        return dict(self.bodies)[step]

    def with_body(self, step: str, body: Body) -> State:
        return self._replace(bodies=tuple((one, body if one == step else other)
                                          for one, other in self.bodies))

    @property
    def running(self) -> List[str]:
        return [step for step, body in self.bodies if body.key]


LIMITS = ('manager', 'driver', 'timeout', 'cancel', 'moved', 'fail', 'changed')


@dataclass(frozen=True)
class Bounds:
    """How often each kind of event may happen: the manager or the driver restarts, a timeout
    passes, a person cancels, moves the robot, or changes the stops of the mission (`changed`).

    fail   -- how often the mission becomes impossible
    others -- the other stops that a person gives
    orders -- maximum number of commands to begin a step
    last   -- the highest key that the robot has taken for other missions
    """

    stops: Tuple[WorkStop, ...]
    on_cancel: Tuple[WorkStop, ...] = ()
    manager: int = 1
    driver: int = 1
    timeout: int = 1
    cancel: int = 1
    moved: int = 0
    fail: int = 0
    others: Tuple[WorkStop, ...] = ()
    changed: int = 0
    orders: int = 2
    last: int = 0
    words: Tuple[Word, ...] = (Word.DONE, Word.FAILED, Word.UNKNOWN)
    sends_unstored: bool = False

    @property
    def steps(self) -> Dict[str, WorkStep]:
        return {step.type: step
                for stop in (*self.stops, *self.on_cancel, *self.others) for step in stop.steps}

    @property
    def begin(self) -> State:
        situation = Situation(SERIAL, work_of(self.stops, self.on_cancel))
        actor, report = ActorState(1, self.last).report()
        return State(situation, situation, 0, None, actor,
                     tuple((step, Body()) for step in self.steps), 0, AWAY, frozenset(),
                     (report,), tuple(getattr(self, name) for name in LIMITS))


class Flaw(Exception):
    """Something happened that must not happen."""


@dataclass
class Found:
    """The result of a search: the number of states, the flaw, and the events that lead to it."""

    states: int
    flaw: str = ''
    way: List[str] = field(default_factory=list)

    def __str__(self) -> str:
        return f'{self.flaw}:\n' + '\n'.join(self.way)


Answer = TypeVar('Answer')


class Once:
    """Results of the rules, each computed once, because very many states need the same result.

    The arguments are parts of states. `States` keeps equal parts as one object, so the identity of
    the arguments is enough to find a result. A result that is not found is computed again.
    """

    def __init__(self) -> None:
        self._answers: Dict[Tuple[object, ...], Tuple[Any, Tuple[object, ...]]] = {}

    def __call__(self, rule: Callable[..., Answer], *asked: object) -> Answer:
        key = (rule, *map(id, asked))
        known = self._answers.get(key)
        if known is None:  # the table keeps the arguments, so that no other object gets their id
            known = self._answers[key] = rule(*asked), asked
        answer: Answer = known[0]
        return answer


class States:
    """The states that were visited, each once, with the event that led to it.

    Equal parts of states are one object, so the identity of the parts is enough to compare states.
    Nearly all parts of a state come from the previous state. Their identity is known already, so no
    hash of their contents is computed.
    """

    def __init__(self) -> None:
        self._parts: Dict[object, object] = {}
        self._known: Set[int] = set()
        self._number: Dict[Tuple[int, ...], int] = {}
        self.states: List[State] = []
        self.came: List[Tuple[int, str]] = []

    def number(self, state: State, source: int, name: str) -> Tuple[int, bool]:
        """The number of a state, and whether it is new."""
        parts = [part if id(part) in self._known else self._known_part(part) for part in state]
        key = tuple(map(id, parts))
        number = self._number.setdefault(key, len(self.states))
        is_new = number == len(self.states)
        if is_new:
            self.states.append(State(*parts))
            self.came.append((source, name))
        return number, is_new

    def _known_part(self, part: object) -> object:
        known = self._parts.setdefault(part, part)
        self._known.add(id(known))
        return known

    def way(self, number: int) -> List[str]:
        """The events that lead to a state."""
        names: List[str] = []
        while number:
            number, name = self.came[number]
            names.append(name)
        return names[::-1]


def search(bounds: Bounds, live: bool = False, most: Optional[int] = None) -> Found:
    """Visits all states; with `most`, at most this number of states, the nearest first.

    live -- a search of all states also checks that the mission can end from each state
    """
    gc.disable()
    try:
        return _search(bounds, live, most)
    finally:
        gc.enable()


def _search(bounds: Bounds, live: bool, most: Optional[int]) -> Found:
    visited, once, before = States(), Once(), []  # type: States, Once, List[List[int]]
    visited.number(bounds.begin, 0, '')
    number = 0
    while number < len(visited.states) and number != most:
        state = visited.states[number]
        try:
            for name, after in events(state, bounds, once):
                check(state, after, name, bounds, once)
                other, _ = visited.number(_without_what_is_lost(after, once), number, name)
                if live:
                    before += [[] for _ in range(other + 1 - len(before))]
                    before[other].append(number)
        except Flaw as flaw:
            return Found(len(visited.states), str(flaw), visited.way(number))
        number += 1
    if live and number == len(visited.states):
        ends = [k for k, state in enumerate(visited.states)
                if rules.phase_of(state.disk) in FINAL or state.orders == bounds.orders]
        reached = set(ends)
        while ends:
            new = {k for k in before[ends.pop()] if k not in reached}
            reached |= new
            ends += new
        stuck = next((k for k in range(number) if k not in reached), None)
        if stuck is not None:
            return Found(number, 'the mission cannot end any more', visited.way(stuck))
    return Found(number)


def _without_what_is_lost(state: State, once: Once) -> State:
    """The state without the messages that will have no effect, whenever they arrive."""
    return state._replace(
        sent=once(_with_effect, state.sent, state.actor),
        told=state.told if state.left[0] else once(_newer, state.told, state.known))


def _with_effect(sent: FrozenSet[StepCommand], actor: ActorState) -> FrozenSet[StepCommand]:
    return frozenset(command for command in sent
                     if actor.obey(command) != (actor, Reaction.NOTHING))


def _newer(told: Tuple[StepReport, ...], known: Optional[StepReport]) -> Tuple[StepReport, ...]:
    return tuple(report for report in told[:-1] if report.is_newer_than(known)) + told[-1:]


# -- events ---------------------------------------------------------------------------------------


def events(state: State, bounds: Bounds, once: Once) -> Iterator[Tuple[str, State]]:
    """All events that may come now, each with the state after it."""
    yield from _manager(state, bounds, once)
    yield from _robot(state, bounds, once)
    yield from _people(state, once)
    if state.memory != state.disk:
        yield 'the manager stores', state._replace(disk=state.memory)
    yield from _limited(state, bounds, once)


def _where(state: State) -> Where:
    work = state.memory.work
    if work.current == len(work.stops):
        return _STANDS[False, False]
    place = work.stops[work.current].place
    return _STANDS[state.place == place, state.place in (place, place - 1)]


_STANDS = {(is_there, is_near): Where(True, is_there, is_near)
           for is_there in (False, True) for is_near in (False, True)}


def _manager(state: State, bounds: Bounds, once: Once) -> Iterator[Tuple[str, State]]:
    memory, where = state.memory, _where(state)
    after = once(rules.follow, memory, where)
    if after != memory:
        yield 'the manager looks where the robot is', state._replace(memory=after)
        return
    place = once(rules.due_step, memory, where)
    if place is not None and state.orders < bounds.orders and (
            state.known is not None or memory.work.step(place).actor is not Actor.ROBOT):
        run, last = (0, 0) if state.known is None else (state.known.run, state.known.last)
        key = once(rules.next_key, memory.work, last, 0)  # the manager's clock stands at 0
        yield (f'the manager begins {memory.work.step(place).type} under key {key}',
               state._replace(memory=once(rules.begin, memory, place, key, run, 0),
                              orders=state.orders + 1))
    if state.known is not None:
        source = state.memory if bounds.sends_unstored else state.disk
        sent = once(_sent, state.sent, source.work, state.known)
        if sent != state.sent:
            yield 'the manager sends', state._replace(sent=sent)
    for report in state.told:
        if report.is_newer_than(state.known):
            yield (f'report {report.run}.{report.number} arrives',
                   state._replace(known=report, memory=once(rules.heard, memory, report)))


def _sent(sent: FrozenSet[StepCommand], work: Work,
          report: StepReport) -> FrozenSet[StepCommand]:
    """The messages on their way after the manager has sent the due commands."""
    return sent | set(rules.commands(work, report))


def _in_order(sent: FrozenSet[StepCommand]) -> List[StepCommand]:
    return sorted(sent, key=repr)


def _robot(state: State, bounds: Bounds, once: Once) -> Iterator[Tuple[str, State]]:
    for command in once(_in_order, state.sent):
        actor, reaction = once(ActorState.obey, state.actor, command)
        after = _told(state._replace(actor=actor), once)
        if reaction is Reaction.BEGIN:
            after = _begun(after, command, bounds)
        elif reaction is Reaction.BREAK_OFF:
            step = next(step for step, body in state.bodies if body.key == command.key)
            after = after.with_body(step, after.body(step)._replace(is_broken_off=True))
        if after != state:
            yield f'{command.act.name} {command.key} arrives', after
    for step in state.running:
        body = state.body(step)
        gives_nothing = bounds.steps[step].load is LoadEffect.GIVES and not state.carried
        for word in (*bounds.words, *((Word.CANCELLED,) if body.is_broken_off else ())):
            for happened in {Word.DONE: (True,), Word.UNKNOWN: (True, False)}.get(word, (False,)):
                if happened and gives_nothing:
                    continue
                after = _over(state, step, happened, bounds)
                after = after._replace(actor=once(ActorState.end, state.actor, body.key, word))
                yield f'{step} ends {word.name}, {happened}', _told(after, once)
    work, place = state.memory.work, state.place
    if once(rules.gate_is_closed, work) or work.current == len(work.stops):
        return
    stop = work.stops[work.current]
    enters = [step for step in stop.steps if step.when is When.BEFORE_ENTRY]
    ends = [AWAY, *([stop.place - 1] if enters and place != stop.place else [])]
    if once(rules.place_not_to_enter, work) != stop.place:
        ends.append(stop.place)
    for end in ends:
        if place != end:
            yield f'the robot drives to {end}', state._replace(place=end)


def _begun(state: State, command: StepCommand, bounds: Bounds) -> State:
    """The state after the robot begins to carry out a step. Raises Flaw if it must not begin."""
    work, name = state.disk.work, command.type
    place = next((place for place, step, _ in work.steps if step.type == name), None)
    if place is None:
        raise Flaw(f'(e) the robot begins {name}, which is not to be done any more')
    step, own, body = work.step(place), work.progress_of(place), state.body(name)
    if own.state.is_final:
        raise Flaw(f'(e) the robot begins {name}, which has ended')
    if own.key != command.key:
        raise Flaw(f'(e) the robot begins {name} under key {command.key}, but {own.key} is stored')
    if (body.key or body.times) and not step.harmless:
        raise Flaw(f'(e) the robot carries out {name} a second time')
    others = [other for other in state.running if other != name]
    if others and StepBlocking.HARD in [bounds.steps[one].blocking for one in (*others, name)]:
        raise Flaw(f'(e) {name} and {others} run at the same time')
    if work.asking not in (None, place):
        raise Flaw(f'(e) {name} begins while another step waits for an answer')
    near = (work.stops[place.stop].place, work.stops[place.stop].place - (
        step.when is When.BEFORE_ENTRY))
    was_moved = state.left[LIMITS.index('moved')] < bounds.moved
    if step.blocking is not StepBlocking.NONE and state.place not in near and not was_moved:
        raise Flaw(f'(g) {name} begins where the robot is not at its stop')
    return state.with_body(name, Body(command.key, False, body.times))


def _over(state: State, step: str, happened: bool, bounds: Bounds) -> State:
    """The state after a step has stopped; `happened`: the step was carried out."""
    effect = {LoadEffect.NONE: 0, LoadEffect.TAKES: 1, LoadEffect.GIVES: -1}[
        bounds.steps[step].load]
    after = state.with_body(step, Body(0, False, state.body(step).times + happened))
    return after._replace(carried=state.carried + effect * happened)


def _told(state: State, once: Once) -> State:
    """The state after the robot reports its changes. Every report may arrive at any time."""
    last = state.told[-1]
    if (state.actor.run, state.actor.last, state.actor.steps) == (last.run, last.last, last.steps):
        return state
    actor, report = once(ActorState.report, state.actor)
    return state._replace(actor=actor, told=once(_and, state.told, report))


def _and(told: Tuple[StepReport, ...], report: StepReport) -> Tuple[StepReport, ...]:
    return (*told, report)


def _people(state: State, once: Once) -> Iterator[Tuple[str, State]]:
    memory = state.memory
    place = memory.work.answerable
    if place is not None:
        step = memory.work.step(place)
        body = state.body(step.type)
        true = {StepDecision.DONE: bool(body.times) and not body.key,
                StepDecision.SKIP: not body.times and not body.key,
                StepDecision.FAIL: not body.times and not body.key,
                StepDecision.RETRY: not body.times}  # a person may overlook that it still runs
        for said, is_true in true.items():
            if is_true or step.actor is not Actor.ROBOT:
                after, problem = once(rules.answer, memory, said)
                if not problem:
                    yield (f'a person says {said.name} of {step.type}',
                           state._replace(memory=after))
    elif once(rules.phase_of, memory) is WorkPhase.NEEDS_PERSON:
        unloads = memory.load.state is LoadState.LOADED or not state.carried
        load = (rules.said_empty(memory.load) if unloads
                else rules.said_loaded(memory.load, SERIAL))
        after = rules.settle(memory._replace(load=load))  # stored before the person is answered
        yield (f'a person says that the robot is {load.state.value}', state._replace(
            memory=after, disk=after, carried=0 if unloads else state.carried))


def _limited(state: State, bounds: Bounds, once: Once) -> Iterator[Tuple[str, State]]:
    left = dict(zip(LIMITS, state.left))

    def used(name: str, after: State) -> Tuple[str, State]:
        return name, after._replace(left=tuple({**left, name: left[name] - 1}.values()))
    if left['manager']:
        yield used('manager', state._replace(memory=state.disk, known=None))
    if left['driver']:
        gives_nothing = any(bounds.steps[step].load is LoadEffect.GIVES for step in state.running
                            ) and not state.carried
        for happened in (False, True) if state.running and not gives_nothing else (False,):
            after = state
            for step in state.running:
                after = _over(after, step, happened, bounds)
            yield used('driver', _told(after._replace(
                actor=ActorState(state.actor.run + 1)), once))
    if once(rules.phase_of, state.memory) in FINAL:
        return
    if left['timeout']:
        for now in (NOT_MUCH_LATER, LATER):
            after = once(rules.expire, state.memory, now)
            if after != state.memory:
                yield used('timeout', state._replace(memory=after))
    if left['cancel']:
        yield used('cancel', state._replace(memory=once(rules.cancel, state.memory)))
    if left['fail']:
        yield used('fail', state._replace(memory=once(rules.fail, state.memory, NO_WAY)))
    if left['changed']:
        after, problem = once(rules.changed, state.memory, bounds.others)
        if not problem and after != state.memory:
            yield used('changed', state._replace(memory=after))
    if left['moved'] and state.place != AWAY:
        yield used('moved', state._replace(place=AWAY))


# -- invariants -----------------------------------------------------------------------------------


def check(before: State, after: State, name: str, bounds: Bounds, once: Once) -> None:
    """Raises Flaw if an event did something that must not happen."""
    load, carried = after.memory.load, after.carried
    moves_load = any(bounds.steps[step].load for step in after.running)
    if load.state is LoadState.EMPTY and (carried or moves_load):
        raise Flaw(f'(f) the robot counts as empty but carries {carried}, after: {name}')
    if load.state is LoadState.LOADED and (carried != load.count or moves_load):
        raise Flaw(f'(f) the robot counts as loaded with {load.count} but carries {carried}, '
                   f'after: {name}')
    if name.startswith('the robot drives'):
        blocked = [step for step in after.running
                   if bounds.steps[step].blocking is not StepBlocking.NONE]
        if blocked:
            raise Flaw(f'(g) the robot drives while {blocked} is carried out')
    _check_final(before, after, once)


def _check_final(before: State, after: State, once: Once) -> None:
    """Raises Flaw (j) if a step or mission changes although its end is stored."""
    if before.disk is after.disk and not after.running:
        return
    was, phase = once(rules.phase_of, before.disk), once(rules.phase_of, after.disk)
    if was in FINAL and phase is not was:
        raise Flaw(f'(j) the mission was {was}, and changed')
    ended = {step.type: own.state for _, step, own in before.disk.work.steps if own.state.is_final}
    for _, step, own in after.disk.work.steps:
        if ended.get(step.type, own.state) is not own.state:
            raise Flaw(f'(j) {step.type} was {ended[step.type]}, and changed')
    if phase in FINAL and after.running:
        raise Flaw(f'(j) the mission has ended while {after.running} is carried out')
