"""All devices together: data that is stored before it has effects, due exchanges, random tests.

The random machine has requesters that restart, messages that are lost or late, restarts of the node
with and without its memory, a disk that is full, and doors that are slow, stuck, silent or wrong.
"""
from __future__ import annotations

import os
import random
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Tuple

import planted_faults as planted
import pytest

from fleet_devices.core.device import DeviceLimits, DeviceMemory, Exchange, Reading, Stage
from fleet_devices.core.devices import Devices, Periods, StoredDevices
from fleet_devices.drivers.driver import Silent
from fleet_devices.drivers.simulated import (
    FAULTS_OF_DOORS,
    ScriptedFault,
    SimulatedDevice,
)
from route_protocol.devices import (
    UNKNOWN_REQUESTER,
    DeviceMode,
    DeviceReport,
    DeviceRequest,
    DeviceUse,
)

OFFLINE_AFTER = 2.0
LIMITS = DeviceLimits(10.0, OFFLINE_AFTER)
PERIODS = Periods(exchange=0.25, report=0.5)
OPEN, CLOSED = DeviceMode.OPEN, DeviceMode.CLOSED
STEPS = 400_000 if os.environ.get('LD90_LONG_TESTS') == '1' else 20_000


class Disk:
    """The stored data, and whether data can be stored."""

    def __init__(self, memory: Optional[StoredDevices] = None) -> None:
        self.memory = memory or StoredDevices()
        self.is_full = False
        self.writes = 0

    def store(self, memory: StoredDevices) -> None:
        if self.is_full:
            raise OSError(28, 'No space left on device')
        self.memory = memory
        self.writes += 1


def known(*obeyed: DeviceUse) -> StoredDevices:
    return StoredDevices(1, {'gate': DeviceMemory(obeyed)})


def devices_on(disk: Disk, now: float = 0.0, least_run: int = 1) -> Devices:
    return Devices({'gate': LIMITS}, disk.memory, disk.store, least_run, PERIODS, now)


def asked(mode: DeviceMode, number: int, requester: str = 'fleet') -> DeviceRequest:
    return DeviceRequest(requester, 'gate', mode, number)


def exchanged(devices: Devices, reading: Optional[Reading], now: float) -> Exchange:
    [(name, exchange)] = devices.begin_due(now)
    devices.ended(name, reading, '' if reading else 'silent', now)
    return exchange


# -- storing ---------------------------------------------------------------------------------------


def test_a_request_is_stored_before_anything_is_done():
    disk = Disk(known())
    devices = devices_on(disk)
    assert devices.receive(asked(OPEN, 5), 0.0, 3.5) == ''
    assert disk.memory.devices['gate'].obeyed == (DeviceUse('fleet', OPEN, 5, 3.5),)
    assert exchanged(devices, Reading(True, False), 0.0).output is True


def test_a_request_that_cannot_be_stored_is_not_taken_until_it_can():
    disk = Disk(known())
    devices = devices_on(disk)
    disk.is_full = True
    assert 'No space left' in devices.receive(asked(OPEN, 5), 0.0, 0.0)
    assert devices.problem and devices['gate'].stage is Stage.LEFT
    assert exchanged(devices, Reading(False, False), 0.0).output is None
    disk.is_full = False
    assert devices.receive(asked(OPEN, 5), 1.0, 0.0) == ''
    assert not devices.problem and devices['gate'].stage is Stage.HELD


def test_a_repetition_is_not_stored_again():
    disk = Disk(known())
    devices = devices_on(disk)
    devices.receive(asked(OPEN, 5), 0.0, 0.0)
    writes = disk.writes
    for number in (5, 4):
        assert devices.receive(asked(OPEN, number), 1.0, 0.0) == ''
    assert disk.writes == writes


def test_a_device_of_which_nothing_is_stored_has_lost_its_memory():
    assert devices_on(Disk()).reports(0.0)[0].use_of(UNKNOWN_REQUESTER) is not None
    assert devices_on(Disk(known())).reports(0.0)[0].obeyed == ()


def test_the_memory_of_a_device_that_the_site_has_no_more_is_kept():
    use = DeviceUse('fleet', OPEN, 1, 0.0)
    disk = Disk(StoredDevices(1, {'old': DeviceMemory((use,))}))
    devices_on(disk)
    assert disk.memory.devices['old'] == DeviceMemory((use,))


@pytest.mark.parametrize('stored, least, run', [(7, 1, 8), (7, 100, 100), (0, 5, 5)])
def test_the_number_of_a_run_grows_whatever_the_clock_says(stored, least, run):
    assert devices_on(Disk(StoredDevices(stored)), least_run=least).run == run


def test_an_unknown_device_is_named():
    request = DeviceRequest('fleet', 'gaet', OPEN, 1)
    assert devices_on(Disk()).receive(request, 0.0, 0.0) == 'there is no device gaet'


# -- what is due -----------------------------------------------------------------------------------


def test_a_device_is_read_at_its_period_and_at_once_after_a_request():
    devices = devices_on(Disk(known()))
    exchanged(devices, Reading(False, False), 0.0)
    assert devices.begin_due(0.1) == []
    devices.receive(asked(OPEN, 1), 0.1, 0.0)
    assert exchanged(devices, Reading(True, False), 0.1).output is True
    assert devices.begin_due(0.2) == []
    assert len(devices.begin_due(0.1 + PERIODS.exchange)) == 1


def test_a_silent_device_is_not_asked_in_a_hurry():
    devices = devices_on(Disk(known()))
    exchanged(devices, None, 0.0)
    devices.receive(asked(OPEN, 1), 0.1, 0.0)
    assert devices.begin_due(0.1) == []


def test_each_change_is_reported_at_once_and_else_twice_a_second():
    devices = devices_on(Disk(known()))
    reports = devices.reports(0.0)
    assert [report.mode for report in reports] == [DeviceMode.UNKNOWN]
    assert devices.reports(0.1) == []
    exchanged(devices, Reading(False, False), 0.2)
    exchanged(devices, Reading(False, False), 0.45)
    reports += devices.reports(0.45)
    assert reports[-1].mode is CLOSED
    assert devices.reports(0.9) == []
    reports += devices.reports(1.0)
    assert [report.count for report in reports] == [1, 2, 3]


# -- the random machine ----------------------------------------------------------------------------


@dataclass
class Requester:
    """A program with a journal. It stores its number before it asks, and enters only if a report
    says that the device is open for it.
    """

    name: str
    number: int = 0
    wants: bool = False
    inside: bool = False
    newest: Optional[DeviceReport] = None

    def request(self) -> DeviceRequest:
        return asked(OPEN if self.wants else CLOSED, self.number, self.name)

    def change(self) -> None:
        self.number += 1
        self.wants = not self.wants
        self.inside = False if not self.wants else self.inside

    def hear(self, report: DeviceReport) -> None:
        if report.is_newer_than(self.newest):
            self.newest = report
            if self.wants and report.is_open_for(self.name, self.number):
                self.inside = True


class Broken(AssertionError):
    """The machine did something that it must never do."""


@dataclass
class Machine:
    """One door with all faults, two requesters, a person, and a network that loses and delays
    messages.
    """

    seed: int
    now: float = 0.0
    given_back: bool = False
    asked_at: Dict[str, float] = field(default_factory=dict)
    is_healthy: bool = False

    def __post_init__(self) -> None:
        self.random = random.Random(self.seed)
        self.requesters = [Requester(name) for name in 'ab']
        self.late: List[DeviceRequest] = []
        self.late_reports: List[DeviceReport] = []
        self.disk = Disk(known())
        self.devices = devices_on(self.disk)
        faults = []
        at = 5.0
        while at < STEPS:
            length = self.random.uniform(0.2, 15.0)
            faults.append(ScriptedFault(self.random.choice(FAULTS_OF_DOORS), at, at + length))
            at += length + self.random.uniform(0.0, 20.0)
        self.faults = faults
        self.gate = SimulatedDevice(lambda: self.now, 1.5, faults)

    def step(self) -> None:
        self.now += self.random.uniform(0.0, 0.3)
        event = self.random.random()
        if event < 0.06:
            self.random.choice(self.requesters).change()
        elif event < 0.4:
            self.send(self.random.choice(self.requesters).request())
        elif event < 0.45 and self.late:
            self.deliver(self.random.choice(self.late))
        elif event < 0.452:
            self.restart(self.disk.memory)
        elif event < 0.454:
            self.restart(StoredDevices())
        elif event < 0.457 and not any(requester.inside for requester in self.requesters):
            self.deliver(asked(CLOSED, 1, UNKNOWN_REQUESTER))  # a person has checked the door
        elif event < 0.46:
            self.disk.is_full = not self.disk.is_full
        elif event < 0.47 and self.late_reports:
            report = self.random.choice(self.late_reports)
            for requester in self.requesters:
                requester.hear(report)
        self.work()

    def send(self, request: DeviceRequest) -> None:
        if not request.number:
            return
        self.late = [*self.late[-20:], request]
        if self.random.random() < 0.8:
            self.deliver(request)

    def deliver(self, request: DeviceRequest) -> None:
        known = {use.requester: use.number for use in self.devices['gate'].memory.obeyed}
        number = known.get(request.requester, 0)
        if self.devices.receive(request, self.now, self.now) == '' and request.number > number:
            self.asked_at[request.requester] = self.now
            self.given_back |= request.mode is CLOSED

    def restart(self, memory: StoredDevices) -> None:
        self.disk.memory, self.given_back = memory, False
        self.devices = devices_on(self.disk, self.now, least_run=self.devices.run + 1)

    def work(self) -> None:
        for name, exchange in self.devices.begin_due(self.now):
            if exchange.output is False:
                if any(requester.inside for requester in self.requesters):
                    raise Broken('it closes on somebody')
                if not self.given_back:
                    raise Broken('it closes by itself')
            reading, problem = self.exchange(exchange)
            self.devices.ended(name, reading, problem, self.now)
            if reading == Reading(False, False) and self.is_found_closed():
                for requester in self.requesters:  # nobody is in a closed door
                    requester.inside = False
        self.devices.tick(self.now)
        for report in self.devices.reports(self.now):
            self.check(report)
            self.late_reports = [*self.late_reports[-20:], report]
            for requester in self.requesters:
                if self.random.random() < 0.8:
                    requester.hear(report)

    def exchange(self, exchange: Exchange) -> Tuple[Optional[Reading], str]:
        if self.random.random() < 0.03:
            return None, 'lost'
        try:
            reading = self.gate.exchange(exchange.output)
        except Silent as silent:
            return None, str(silent)
        if self.random.random() < 0.02:
            return None, 'the answer is lost'
        return reading, ''

    def is_found_closed(self) -> bool:
        """Returns whether the memory is no longer lost, because the device has just read closed."""
        return self.devices['gate'].alike >= 2

    def check(self, report: DeviceReport) -> None:
        if report.mode is not OPEN:
            return
        assert report.read_at is not None
        if self.now - report.read_at > OFFLINE_AFTER:
            raise Broken('OPEN is said of an old reading')
        for use in report.obeyed:
            at = self.asked_at.get(use.requester, 0.0)
            if use.requester != UNKNOWN_REQUESTER and report.read_at < at:
                raise Broken('OPEN is said of what was read before the request')
        lies = any(fault.begin <= self.now + 3.0 and self.now - 3.0 < fault.end
                   for fault in self.faults)
        if not lies and not self.gate.is_passable:
            raise Broken('OPEN is said of a door that is closed')


def run(seed: int, steps: int) -> int:
    """Runs a machine. Returns how often a requester came in."""
    machine, entries = Machine(seed), 0
    for _ in range(steps):
        before = [requester.inside for requester in machine.requesters]
        machine.step()
        entries += sum(now.inside and not was
                       for was, now in zip(before, machine.requesters))
    return entries


@pytest.mark.parametrize('seed', range(4))
def test_nothing_makes_it_close_on_somebody_or_say_open_of_what_is_old(seed):
    assert run(seed, STEPS // 4) > STEPS // 4000


@pytest.mark.parametrize('plant', [
    planted.forgets_no_number, planted.shows_what_was_not_read, planted.closes_after_a_start,
    planted.forgets_that_the_memory_is_lost, planted.closes_for_the_first_who_gives_back,
    planted.ends_a_use_by_time, planted.is_never_offline], ids=lambda plant: plant.__name__)
def test_the_machine_finds_a_rule_that_is_left_out(plant, monkeypatch):
    plant(monkeypatch)
    with pytest.raises(Broken):
        for seed in range(4):
            run(seed, STEPS // 4)
