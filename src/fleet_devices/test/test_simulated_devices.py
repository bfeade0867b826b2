"""A simulated door moves with time, and fails as its script says."""
from __future__ import annotations

import pytest

from fleet_devices.core.device import Reading
from fleet_devices.drivers.driver import Silent
from fleet_devices.drivers.simulated import SLOWER, FaultKind, ScriptedFault, SimulatedDevice

TRAVEL = 2.0


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def door(*faults: ScriptedFault):
    clock = Clock()
    return clock, SimulatedDevice(clock, TRAVEL, faults)


def fault(kind: FaultKind, begin: float = 0.0, end: float = 100.0) -> ScriptedFault:
    return ScriptedFault(kind, begin, end)


def test_it_opens_and_closes_in_its_time():
    clock, gate = door()
    assert gate.exchange(None) == Reading(False, False)
    assert gate.exchange(True) == Reading(True, False)
    clock.now += TRAVEL
    assert gate.exchange(None) == Reading(True, True)
    assert gate.exchange(False) == Reading(False, True)
    clock.now += TRAVEL
    assert gate.exchange(None) == Reading(False, False)


@pytest.mark.parametrize('kind, after', [
    (FaultKind.SLOW, {TRAVEL: False, TRAVEL * SLOWER: True}),
    (FaultKind.STUCK, {TRAVEL * SLOWER: False}),
    (FaultKind.SHUT, {TRAVEL * SLOWER: False})])
def test_a_fault_keeps_it_from_opening(kind, after):
    clock, gate = door(fault(kind))
    gate.exchange(True)
    for time, is_open in after.items():
        clock.now = time
        assert gate.exchange(None) == Reading(True, is_open)
        assert gate.is_passable is is_open


def test_a_device_that_lies_says_the_opposite_and_is_what_it_is():
    clock, gate = door(fault(FaultKind.LYING, begin=TRAVEL))
    gate.exchange(True)
    clock.now = TRAVEL
    assert gate.exchange(None) == Reading(True, False) and gate.is_passable


def test_a_silent_device_obeys_nothing_until_it_comes_back():
    clock, gate = door(fault(FaultKind.SILENT, end=1.0))
    with pytest.raises(Silent):
        gate.exchange(True)
    clock.now = 1.0
    assert gate.exchange(None) == Reading(False, False)
