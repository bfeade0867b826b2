"""One device: the texts about its faults, and its memory of many requesters."""
from __future__ import annotations

from typing import Sequence

import pytest

from fleet_devices.core.device import (
    KEPT,
    LOST,
    MOST_HOLDERS,
    DeviceLimits,
    DeviceMachine,
    DeviceMemory,
    Reading,
    Stage,
)
from route_protocol.devices import DeviceFault, DeviceMode, DeviceRequest

LIMITS = DeviceLimits(timeout=3.0, offline_after=2.0)
ON, OFF = (True, True), (False, False)


def asked(mode: DeviceMode, number: int = 1, requester: str = 'fleet') -> DeviceRequest:
    return DeviceRequest(requester, 'gate', mode, number)


def read(device: DeviceMachine, readings: Sequence[Sequence[bool]],
         now: float = 0.0) -> DeviceMachine:
    """The device after one reading each second."""
    for k, bits in enumerate(readings):
        device, _ = device.begin(now + k)
        device = device.end(Reading(*bits), '', now + k)
    return device


def held() -> DeviceMachine:
    return DeviceMachine.start(LIMITS, DeviceMemory(), 0.0).ask(asked(DeviceMode.OPEN), 0.0, 0.0)


@pytest.mark.parametrize('readings, told', [
    ([OFF] * 6, 'it does not open within 3 s: it reads closed'),
    ([(True, False)] * 6, 'it does not open within 3 s: its output is on, and it does not read '
                          'open'),
    ([(False, True)] * 6, 'it does not open within 3 s: its output is off, and it reads open'),
    ([ON, OFF] * 3, 'it does not open within 3 s: its readings change')])
def test_a_device_that_does_not_open_says_what_it_reads(readings, told):
    report = read(held(), readings).report('gate')
    assert (report.mode, report.fault, report.reason) == (
        DeviceMode.UNKNOWN, DeviceFault.TIMED_OUT, told)


def test_a_device_that_does_not_close_says_so_and_is_closed_when_it_can_be():
    device = read(held(), [ON, ON]).ask(asked(DeviceMode.CLOSED, 2), 2.0, 0.0)
    stuck = read(device, [(False, True)] * 6, 2.0)
    assert 'does not close within 3 s' in stuck.report('gate').reason
    closed = read(stuck, [OFF, OFF], 8.0)
    assert closed.mode is DeviceMode.CLOSED and closed.stage is Stage.LEFT
    assert closed.report('gate').reason == ''


def test_a_silent_device_is_offline_for_the_reason_of_its_driver_and_must_be_read_anew():
    device = read(held(), [ON, ON])
    device, _ = device.begin(2.0)
    device = device.end(None, 'the plug is out', 3.5)
    report = device.report('gate')
    assert (report.mode, report.reason) == (DeviceMode.OFFLINE, 'the plug is out')
    assert read(device, [ON], 4.0).mode is DeviceMode.MOVING
    assert read(device, [ON, ON], 4.0).mode is DeviceMode.OPEN


def test_a_device_whose_exchange_never_ends_is_offline_too():
    device, _ = held().begin(0.0)
    assert device.tick(LIMITS.offline_after + 0.1).report('gate').reason == 'it does not answer'


def test_only_so_many_may_hold_a_device():
    device = DeviceMachine.start(LIMITS, DeviceMemory(), 0.0)
    for k in range(MOST_HOLDERS):
        device = device.ask(asked(DeviceMode.OPEN, 1, f'robot {k}'), 0.0, 0.0)
    one_more = asked(DeviceMode.OPEN)
    assert 'others hold it already' in device.refusal(one_more)
    assert device.ask(one_more, 0.0, 0.0) is device
    again = asked(DeviceMode.OPEN, 2, 'robot 0')
    assert device.refusal(again) == '' and device.ask(again, 0.0, 0.0) is not device


def test_who_holds_a_device_is_never_forgotten_and_who_does_not_after_many_others():
    device = held()
    for k in range(KEPT + 5):
        device = device.ask(asked(DeviceMode.CLOSED, 1, f'robot {k}'), 0.0, 0.0)
    known = [taken.use.requester for taken in device.obeyed]
    assert known == ['fleet', *(f'robot {k}' for k in range(5, KEPT + 5))]


def test_a_lost_memory_is_kept_as_lost_until_the_device_reads_closed():
    device = DeviceMachine.start(LIMITS, LOST, 0.0)
    for readings, is_lost in (([ON, ON], True), ([OFF], True), ([OFF, OFF], False)):
        assert read(device, readings).memory.is_lost is is_lost
