"""Every state of one device, for all readings, with lost and late requests, and restarts.

Two requesters send numbered requests (odd numbers: OPEN, even numbers: CLOSED). Each request may be
lost, late or repeated. The device shows anything at any time, or nothing. The node restarts with or
without its memory. The search uses the real `DeviceMachine`. *Ghosts* are data that the machine
does not keep, but that the checks need.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Callable, Iterator, Optional, Set, Tuple

import planted_faults as planted
import pytest
from proofs import is_whole
from state_search import Broken, visited

from fleet_devices.core.device import LOST, DeviceLimits, DeviceMachine, Reading, Stage
from route_protocol.devices import UNKNOWN_REQUESTER, DeviceMode, DeviceReport, DeviceRequest

TIMEOUT = OFFLINE_AFTER = 1
LIMITS = DeviceLimits(TIMEOUT, OFFLINE_AFTER)
OLD = 2           # all ages of at least this are equivalent: they are above both limits
STEADY = 2
REQUESTERS = ('a', 'b')
MOST = {'a': 2, 'b': 1 if is_whole(__file__) else 0}  # the number of a requester's last request
READINGS = tuple(Reading(*bits) for bits in product((False, True), repeat=2))
WAITING = (DeviceMode.MOVING, DeviceMode.UNKNOWN)
OPENED, CLOSED = Reading(True, True), Reading(False, False)


@dataclass(frozen=True)
class World:
    """The device, time, and the ghosts.

    sent       -- the number of the newest request of each requester
    inside     -- for each requester, whether it may be in the device: a report said that the
                  device is open for its newest request, and it has not given the device back
    heard      -- for each requester, the state of the exchanges that began after its newest request
                  was taken: 0: there is none, 1: one is under way, 2: one had a reading
    readings   -- the last readings that count: those after a start, a silence or a new stage
    gave_back  -- whether a claim was given back since the start
    must_close -- whether the last claim was given back, and the device did not read closed since
    begun_since -- whether an exchange has begun in this stage of the device
    """

    device: DeviceMachine
    now: float = 0
    sent: Tuple[int, ...] = (0, 0)
    inside: Tuple[bool, ...] = (False, False)
    heard: Tuple[int, ...] = (2, 2)
    readings: Tuple[Reading, ...] = ()
    read_at: Optional[float] = None
    gave_back: bool = False
    must_close: bool = False
    begun_since: bool = False


def key(world: World) -> object:
    """The part of the state that decides the future: ages instead of times, relations instead of
    counts.

    Two facts about the readings that count are enough: the last reading, and whether the reading
    before it was equal.
    """
    last = world.readings[-1:]
    return (*device_key(world.device, world.now), world.sent, world.inside, world.heard, last,
            world.readings == last * STEADY,
            None if world.read_at is None else min(world.now - world.read_at, OLD),
            world.gave_back, world.must_close, world.begun_since)


def device_key(device: DeviceMachine, now: float) -> Tuple:
    """The part of the state that decides the future of the device alone."""
    def age(time: Optional[float]) -> Optional[float]:
        return None if time is None else min(now - time, OLD)
    return (tuple((one.use.requester, one.use.mode, one.use.number, device.begun > one.begun,
                   device.read > one.begun) for one in device.obeyed),
            device.is_memory_lost, device.is_closing,
            age(device.begun_at) if device.is_awaited else None,
            age(device.read_at), device.output, device.settled if device.alike else None,
            device.alike, device.begun > device.stage_from, device.mode, device.fault,
            age(device.moving_from) if device.mode in WAITING else None, bool(device.problem),
            age(device.since) if device.read_at is None else None)


def put(values: Tuple, index: int, value: object) -> Tuple:
    return (*values[:index], value, *values[index + 1:])


def is_open_request(number: int) -> bool:
    return number % 2 == 1


def requested(requester: int, number: int) -> DeviceRequest:
    mode = DeviceMode.OPEN if is_open_request(number) else DeviceMode.CLOSED
    return DeviceRequest(REQUESTERS[requester], 'gate', mode, number)


# --- events ---------------------------------------------------------------------------------------


def send(world: World, who: int) -> World:
    number = world.sent[who] + 1
    inside = world.inside if is_open_request(number) else put(world.inside, who, False)
    return replace(world, sent=put(world.sent, who, number), inside=inside)


def deliver(world: World, who: int, number: int) -> World:
    after = world.device.ask(requested(who, number), world.now, 0.0)
    known = {one.use.requester: one.use.number for one in after.obeyed}[REQUESTERS[who]]
    before = {one.use.requester: one.use.number for one in world.device.obeyed}
    if known < max(number, before.get(REQUESTERS[who], 0)):
        raise Broken('NUMBERS GROW', f'{known} after {number}')
    if after is world.device:
        return world
    is_new = number > before.get(REQUESTERS[who], 0)
    held = after.stage is Stage.HELD
    restart = after.stage is not world.device.stage
    return told(replace(
        world, device=after,
        heard=put(world.heard, who, 0) if is_new else world.heard,
        readings=() if restart else world.readings,
        begun_since=world.begun_since and not restart,
        gave_back=world.gave_back or not is_open_request(number),
        must_close=not held and not after.is_memory_lost and (
            world.must_close or not is_open_request(number))))


def release_unknown(world: World) -> World:
    """A person has checked that no robot is in the device, and ends the use by `unknown`."""
    request = DeviceRequest(UNKNOWN_REQUESTER, 'gate', DeviceMode.CLOSED, 9)
    after = world.device.ask(request, world.now, 0.0)
    known = {one.use.requester for one in after.obeyed if one.use.holds}
    inside = tuple(is_in and name in known for is_in, name in zip(world.inside, REQUESTERS))
    is_same = after.stage is world.device.stage
    return replace(world, device=after, inside=inside, gave_back=True,
                   readings=world.readings if is_same else (),
                   begun_since=world.begun_since and is_same)


def begin(world: World) -> World:
    before = world.device
    after, exchange = before.begin(world.now)
    if exchange.output is False:
        if any(world.inside) or any(one.use.holds for one in before.obeyed):
            raise Broken('NEVER CLOSES ON A HOLDER', 'somebody holds it')
        if not world.gave_back:
            raise Broken('NEVER CLOSES ON A HOLDER', 'nothing was given back')
    reads_on = bool(world.readings) and world.readings[-1].output and not before.problem
    if before.stage is Stage.HELD and exchange.output is not True and not reads_on and (
            before.output is None or not before.output):
        raise Broken('HELD IS OPENED', str(exchange))
    if before.stage is Stage.HELD and before.problem and exchange.output is not True:
        raise Broken('HELD IS OPENED', 'after an exchange without a reading')
    return replace(world, device=after, heard=tuple(max(one, 1) for one in world.heard),
                   begun_since=True)


def end(world: World, reading: Optional[Reading]) -> World:
    began = world.device.begun_at
    after = world.device.end(reading, '' if reading else 'it is silent', world.now)
    if reading is None:
        return told(replace(world, device=after, heard=tuple(
            0 if one == 1 else one for one in world.heard)))
    readings = (*world.readings, reading)[-STEADY:] if world.begun_since else ()
    is_closed = readings == (CLOSED,) * STEADY
    world = replace(
        world, device=after, heard=tuple(2 if one else 0 for one in world.heard),
        readings=readings, read_at=began, must_close=world.must_close and not is_closed)
    if is_closed:  # nobody is in a closed device
        known = {one.use.requester for one in after.obeyed if one.use.holds}
        world = replace(world, inside=tuple(
            is_in and name in known for is_in, name in zip(world.inside, REQUESTERS)))
    return told(world)


def pass_time(world: World) -> World:
    now = world.now + 1
    after = world.device.tick(now)
    silent = world.read_at is not None and now - world.read_at > OFFLINE_AFTER
    return told(replace(world, device=after, now=now,
                        readings=() if silent else world.readings))


def restart(world: World, keeps: bool) -> World:
    device = DeviceMachine.start(LIMITS, world.device.memory if keeps else LOST, world.now)
    return told(replace(world, device=device, heard=(0, 0), readings=(), read_at=None,
                        gave_back=False, must_close=False, begun_since=False))


def told(world: World) -> World:
    """Checks the report of the device, and lets the requesters read this report."""
    report = world.device.report('gate')
    if report.mode is DeviceMode.OPEN:
        if world.readings != (OPENED,) * STEADY:
            raise Broken('OPEN IS NEW', f'it has read {world.readings}')
        if world.read_at is None or world.now - world.read_at > OFFLINE_AFTER:
            raise Broken('OPEN IS NEW', 'the reading is old')
        for who, name in enumerate(REQUESTERS):
            if report.use_of(name) is not None and world.heard[who] != 2:
                raise Broken('OPEN IS NEW', f'not read since {name} asked')
    inside = world.inside
    for who, name in enumerate(REQUESTERS):
        if is_open_request(world.sent[who]) and report.is_open_for(name, world.sent[who]):
            inside = put(inside, who, True)
    return replace(world, inside=inside)


Step = Tuple[str, Callable[[World], World]]


def steps(world: World) -> Iterator[Step]:
    for who, name in enumerate(REQUESTERS):
        if world.sent[who] < MOST[name]:
            yield f'{name} sends', lambda w, who=who: send(w, who)
        for number in range(1, world.sent[who] + 1):
            yield f'{name} {number} comes', lambda w, who=who, n=number: deliver(w, who, n)
    if world.device.is_awaited:
        for reading in (*READINGS, None):
            yield f'{reading}', lambda w, reading=reading: end(w, reading)
    else:
        yield 'an exchange begins', begin
    yield 'time passes', pass_time
    yield 'restart', lambda w: restart(w, True)
    yield 'restart without memory', lambda w: restart(w, False)
    if world.device.is_memory_lost:
        yield 'a person gives back for unknown', release_unknown


# --- the device that works again ------------------------------------------------------------------


def check_live(world: World, checked: Set[object]) -> None:
    """The device reaches its mode if from now on no message is lost, and the device obeys.

    checked -- the states that were checked before
    """
    known = *device_key(world.device, world.now), world.sent, world.must_close
    if known in checked:
        return
    checked.add(known)
    for physical in ((False, True) if world.must_close or any(
            map(is_open_request, world.sent)) else ()):
        check_life(world, physical)


def check_life(world: World, output: bool) -> None:
    device, now = world.device, world.now
    if device.is_awaited:
        device = device.end(None, 'silent', now)
    for who, number in enumerate(world.sent):
        if number:
            device = device.ask(requested(who, number), now, 0.0)
    for _ in range(2 * STEADY + 2):
        device, exchange = device.begin(now)
        output = output if exchange.output is None else exchange.output
        device = device.end(Reading(output, output), '', now)
    report: DeviceReport = device.report('gate')
    for who, name in enumerate(REQUESTERS):
        number = world.sent[who]
        if is_open_request(number) and not report.is_open_for(name, number):
            raise Broken('LIVE', f'it does not open for {name}: {report}')
    if (world.must_close and not any(map(is_open_request, world.sent))
            and report.mode is not DeviceMode.CLOSED):
        raise Broken('LIVE', f'it does not close: {report}')


# --- search ---------------------------------------------------------------------------------------


def search(live: bool = True) -> int:
    """Visits every state. Returns the number of states; raises Broken with the path."""
    lives: Set[object] = set()
    return visited(World(DeviceMachine.start(LIMITS, LOST, 0)), key, steps,
                   lambda world: check_live(world, lives) if live else None)


def test_no_state_breaks_an_invariant() -> None:
    assert search() > 1000


# --- each rule left out ---------------------------------------------------------------------------

PLANTED = {
    planted.forgets_no_number: 'NUMBERS GROW',
    planted.believes_one_reading: 'OPEN IS NEW',
    planted.believes_readings_that_differ: 'OPEN IS NEW',
    planted.shows_what_was_not_read: 'OPEN IS NEW',
    planted.keeps_readings_over_a_silence: 'OPEN IS NEW',
    planted.keeps_readings_over_a_stage: 'OPEN IS NEW',
    planted.believes_an_output_that_was_not_read: 'HELD IS OPENED',
    planted.is_never_offline: 'OPEN IS NEW',
    planted.closes_after_a_start: 'NEVER CLOSES ON A HOLDER',
    planted.forgets_that_the_memory_is_lost: 'NEVER CLOSES ON A HOLDER',
    planted.closes_for_the_first_who_gives_back: 'NEVER CLOSES ON A HOLDER',
    planted.ends_a_use_by_time: 'NEVER CLOSES ON A HOLDER',
    planted.opens_once_only: 'HELD IS OPENED',
    planted.never_closes: 'LIVE',
}


BY_TWO = (planted.forgets_that_the_memory_is_lost,)
"""Faults that show only if both requesters send. For all other faults, a search without b is used,
because it is shorter."""


@pytest.mark.parametrize('plant', PLANTED, ids=lambda plant: plant.__name__)
def test_each_rule_left_out_is_found(plant, monkeypatch):
    plant(monkeypatch)
    monkeypatch.setitem(MOST, 'b', int(plant in BY_TWO))
    with pytest.raises(Broken) as broken:
        search(live=PLANTED[plant] == 'LIVE')
    assert broken.value.args[0] == PLANTED[plant], broken.value
