"""Every state of one device that carries out steps, with lost and late commands, and restarts.

The fleet manager orders two steps, and may cancel each. A command may be lost, late or repeated.
Each exchange may have its effect but no reading. The device works, fails, does not react, loses its
memory, or shows anything. The node restarts between any two events, with its stored memory. The
search uses the real `HandOverMachine`. *Ghosts* are data that the machine does not keep, but that
the checks need.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Callable, Iterator, NamedTuple, Optional, Set, Tuple

import pytest
from proofs import LONG, is_whole
from state_search import Broken, visited

from fleet_devices.core.device import DeviceLimits
from fleet_devices.core.hand_over import (
    RUNNING,
    HandOverMachine,
    HandOverMemory,
    HandOverPhase,
    Signals,
    StartSignal,
)
from route_protocol.steps import StepAct, StepCode, StepCommand, Word

LIMITS = DeviceLimits(timeout=1, offline_after=1)
OLD = 2
RUN = 5
KEYS = (1, 2)
COMMANDS = tuple(StepCommand(key, act, RUN, 'handshake' if act is StepAct.DO else '')
                 for act, key in ((StepAct.DO, 1), (StepAct.CANCEL, 1), (StepAct.DO, 2),
                                  (StepAct.REVOKE, 1), (StepAct.CANCEL, 2), (StepAct.REVOKE, 2)))
WHOLE = is_whole(__file__)
BOUNDS = (((2, 1, 1), (3, 0, 0)) if LONG else ((2, 1, 0), (2, 0, 1)) if WHOLE
          else ((1, 1, 0), (2, 0, 0)))
"""The bounds of each search: numbers of commands, restarts and power cuts."""
MOST_RESTARTS, MOST_POWER_CUTS = 1, 0


class Press(NamedTuple):
    """The true state of the device."""

    start: bool = False
    key: int = 0
    done: bool = False
    failed: bool = False

    @property
    def signals(self) -> Signals:
        return Signals(*self)


@dataclass(frozen=True)
class World:
    """The state of everything.

    stored  -- the data on the disk
    write   -- the start signal that the awaited exchange writes; None: it writes nothing
    started -- how often the start of each key was written
    said    -- for each key, whether the device has shown *done* and *failed* while it had this key
    """

    device: HandOverMachine
    stored: HandOverMemory
    now: float = 0
    press: Press = Press()
    write: Optional[StartSignal] = None
    started: Tuple[int, ...] = (0, 0)
    said: Tuple[Tuple[bool, bool], ...] = ((False, False), (False, False))
    restarts: int = 0
    power_cuts: int = 0


def key_of(world: World) -> object:
    """The part of the state that decides the future: ages instead of times, relations instead of
    counts.
    """
    device = world.device

    def age(time: Optional[float]) -> Optional[float]:
        return None if time is None else min(world.now - time, OLD)
    return (device.actor.last, device.actor.steps, device.phase, device.key, age(device.since),
            device.begun > device.phase_from, age(device.begun_at) if device.is_awaited else None,
            age(device.read_at), device.signals, device.alike, bool(device.problem),
            replace(world.stored, lives=0), world.press, world.write, world.started, world.said,
            world.restarts, world.power_cuts)


def put(values: Tuple, index: int, value: object) -> Tuple:
    return (*values[:index], value, *values[index + 1:])


# --- events ---------------------------------------------------------------------------------------


def command(world: World, what: StepCommand) -> World:
    return told(world, world.device.obey(what, world.now))


def begin(world: World) -> World:
    device, write = world.device.begin(world.now)
    world = told(world, device)
    started = world.started
    if write is not None and write.is_on:
        index = KEYS.index(write.key)
        started = put(started, index, started[index] + 1)
        if started[index] > 1:
            raise Broken('ONCE', f'the start of {write.key} is written again')
        if (world.stored.phase, world.stored.key) != (HandOverPhase.WORKING, write.key):
            raise Broken('STORED', str(world.stored))
    return replace(world, write=write, started=started)


def end(world: World, is_written: bool, is_read: bool) -> World:
    press, write = world.press, world.write
    if write is not None and is_written:
        press = Press(True, write.key) if write.is_on else press._replace(start=False)
    world = replace(world, press=press, write=None)
    return told(world, world.device.end(press.signals if is_read else None,
                                        '' if is_read else 'it is silent', world.now))


def press_ends(world: World, failed: bool) -> World:
    """A press shows how a step has ended. A faulty press shows both ends, or changes the end."""
    press = world.press._replace(**{'failed' if failed else 'done': True})
    if press.key not in KEYS:
        return replace(world, press=press)
    index = KEYS.index(press.key)
    done_failed = world.said[index]
    said = put(world.said, index, put(done_failed, int(failed), True))
    return replace(world, press=press, said=said)


def press_clears(world: World) -> World:
    return replace(world, press=world.press._replace(done=False, failed=False))


def power_cut(world: World) -> World:
    return replace(world, press=Press(), power_cuts=world.power_cuts + 1)


def pass_time(world: World) -> World:
    world = replace(world, now=world.now + 1)
    return told(world, world.device.tick(world.now))


def restart(world: World) -> World:
    """The node restarts. The awaited exchange had its effect before the restart, or has none."""
    device = HandOverMachine.start(LIMITS, world.stored, world.now)
    return replace(told(world, device), write=None, restarts=world.restarts + 1)


def told(world: World, device: HandOverMachine) -> World:
    """Stores the memory of the device, and checks the reports on its steps."""
    before = {step.key: step for step in world.device.actor.steps}
    running = [step.key for step in device.actor.steps if not step.word.is_final]
    if len(running) > 1 or running != ([device.key] if device.phase in RUNNING else []):
        raise Broken('ONE RUNS', f'{running} in {device.phase}')
    for step in device.actor.steps:
        was = before.get(step.key)
        if was is not None and was.word.is_final and was != step:
            raise Broken('TRUE', f'{was} became {step}')
        if not step.word.is_final or was == step:
            continue
        index = KEYS.index(step.key)
        done, failed = world.said[index]
        if step.word is Word.DONE and not done:
            raise Broken('TRUE', f'{step.key} was not done')
        not_begun = step.word in (Word.FAILED, Word.CANCELLED) and not failed
        if not_begun and world.started[index]:
            raise Broken('NOT BEGUN', f'{step} was started')
    return replace(world, device=device, stored=device.memory)


Event = Tuple[str, Callable[[World], World]]


def events(world: World) -> Iterator[Event]:
    for what in COMMANDS:
        yield f'{what.act.name} {what.key}', lambda w, what=what: command(w, what)
    if world.device.is_awaited:
        for is_written, is_read in product((True, False), repeat=2):
            yield (f'the exchange ends, written {is_written}, read {is_read}',
                   lambda w, one=is_written, two=is_read: end(w, one, two))
    else:
        yield 'an exchange begins', begin
    press = world.press
    says_both = WHOLE or not (press.done or press.failed)
    if press.start and not press.failed and says_both:
        yield 'it fails', lambda w: press_ends(w, True)
    if press.start and not press.done and says_both:
        yield 'it is done', lambda w: press_ends(w, False)
    if not press.start and (press.done or press.failed):
        yield 'it clears its inputs', press_clears
    if world.power_cuts < MOST_POWER_CUTS and press != Press():
        yield 'it loses its memory', power_cut
    yield 'time passes', pass_time
    if world.restarts < MOST_RESTARTS:
        yield 'restart', restart
        if world.write is not None:
            yield 'restart after the writing', lambda w: restart(end(w, True, False))


# --- search ---------------------------------------------------------------------------------------


def check_live(world: World, checked: Set[object]) -> None:
    """A running step ends if from now on the device works, or is silent.

    checked -- the states that were checked before
    """
    known = key_of(replace(world, stored=HandOverMemory(RUN), started=(), said=(), restarts=0,
                           power_cuts=0, write=None))
    if world.device.phase not in RUNNING or known in checked:
        return
    checked.add(known)
    device, press, now = world.device, world.press, world.now
    if device.is_awaited:
        device = device.end(None, 'it is silent', now)
    for _ in range(25):
        now += 0.1
        device, write = device.begin(now)
        if write is not None:
            press = Press(True, write.key) if write.is_on else press._replace(start=False)
        device = device.end(press.signals, '', now)
        press = press._replace(done=press.start, failed=False)
    if device.phase in RUNNING:
        raise Broken('LIVE', f'{device.phase} at a device that works')
    device, now = world.device, world.now
    for _ in range(4):
        now += 1
        device = device.tick(now)
    if device.phase in RUNNING:
        raise Broken('LIVE', f'{device.phase} at a device that is silent')


def search(live: bool = True) -> int:
    """Visits every state. Returns the number of states; raises Broken with the path."""
    memory = HandOverMemory(RUN)
    lives: Set[object] = set()
    return visited(World(HandOverMachine.start(LIMITS, memory, 0), memory), key_of, events,
                   lambda world: check_live(world, lives) if live else None)


@pytest.mark.parametrize('commands, restarts, power_cuts', BOUNDS)
def test_no_state_breaks_an_invariant(monkeypatch, commands, restarts, power_cuts):
    monkeypatch.setitem(globals(), 'COMMANDS', COMMANDS[:commands])
    monkeypatch.setitem(globals(), 'MOST_RESTARTS', restarts)
    monkeypatch.setitem(globals(), 'MOST_POWER_CUTS', power_cuts)
    assert search() > 1000


# --- each rule left out ---------------------------------------------------------------------------


def starts_again_after_a_start(patch: pytest.MonkeyPatch) -> None:
    begun = HandOverMachine.start.__func__

    def wrong(cls: type, limits: DeviceLimits, memory: HandOverMemory,
              now: float) -> HandOverMachine:
        phase = HandOverPhase.READYING if memory.phase is HandOverPhase.WORKING else memory.phase
        return begun(cls, limits, replace(memory, phase=phase), now)
    patch.setattr(HandOverMachine, 'start', classmethod(wrong))
    patch.setattr(HandOverMachine, '_was_started', lambda self: False)
    patch.setattr(HandOverMachine, '_give_up',
                  lambda self, code, text, now: self._unknown(text, now))


def starts_what_is_not_stored(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(HandOverMachine, 'memory', property(lambda self: HandOverMemory(
        self.actor.run, self.lives, self.actor.last, self.actor.steps,
        HandOverPhase.READYING if self.phase is HandOverPhase.WORKING else self.phase, self.key)))


def believes_a_done_of_another_key(patch: pytest.MonkeyPatch) -> None:
    judge = HandOverMachine._judge

    def wrong(self: HandOverMachine, now: float) -> HandOverMachine:
        if self.signals is None or self.signals.failed:
            return judge(self, now)
        own = self.signals._replace(start=True, key=self.key)
        return replace(judge(replace(self, signals=own), now), signals=self.signals)
    patch.setattr(HandOverMachine, '_judge', wrong)
    patch.setattr(Signals, 'are_off', property(lambda self: not self.start))
    patch.setitem(globals(), 'MOST_RESTARTS', 0)


def begins_a_second_step(patch: pytest.MonkeyPatch) -> None:
    obey = HandOverMachine.obey

    def wrong(self: HandOverMachine, command: StepCommand, now: float) -> HandOverMachine:
        after = obey(replace(self, phase=HandOverPhase.IDLE), command, now)
        return after if after.key != self.key else replace(after, phase=self.phase)
    patch.setattr(HandOverMachine, 'obey', wrong)


def says_failed_of_what_was_started(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(HandOverMachine, '_give_up', lambda self, code, text, now: self._ended(
        Word.FAILED, code, text, HandOverPhase.LEFT, now))


def waits_for_a_silent_device(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(HandOverMachine, 'tick', lambda self, now: self)


def cancels_what_was_started(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(HandOverMachine, '_break_off', lambda self, now: self._ended(
        Word.CANCELLED, StepCode.NONE, '', HandOverPhase.IDLE, now))


PLANTED = {  # for each fault, the invariant that breaks, and the commands that may be sent
    starts_again_after_a_start: ('ONCE', COMMANDS[:1]),
    starts_what_is_not_stored: ('STORED', COMMANDS[:1]),
    believes_a_done_of_another_key: ('TRUE', COMMANDS[0:3:2]),
    begins_a_second_step: ('ONE RUNS', COMMANDS[:3]),
    says_failed_of_what_was_started: ('NOT BEGUN', COMMANDS[:2]),
    waits_for_a_silent_device: ('LIVE', COMMANDS[:1]),
    cancels_what_was_started: ('NOT BEGUN', COMMANDS[:2])}


@pytest.mark.parametrize('plant', PLANTED, ids=lambda plant: plant.__name__)
def test_each_rule_left_out_is_found(plant, monkeypatch):
    plant(monkeypatch)
    name, commands = PLANTED[plant]
    monkeypatch.setitem(globals(), 'COMMANDS', commands)
    with pytest.raises(Broken) as broken:
        search(live=name == 'LIVE')
    assert broken.value.args[0] == name, broken.value
