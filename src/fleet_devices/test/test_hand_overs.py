"""Devices that carry out steps, with a simulated press and a memory that can fail."""
from __future__ import annotations

from typing import List, Optional, Sequence, Tuple

import pytest

from fleet_devices.core.device import DeviceLimits
from fleet_devices.core.hand_overs import HandOvers, StoredHandOvers
from fleet_devices.drivers.driver import Silent
from fleet_devices.drivers.simulated import FaultKind, ScriptedFault, SimulatedHandOver
from route_protocol.steps import ShownStep, StepAct, StepCode, StepCommand, StepReport, Word

LIMITS = {'press': DeviceLimits(timeout=5.0, offline_after=2.0)}
ALWAYS = 1e9


class Disk:
    """Keeps the data that was stored last; while the disk is full, nothing is stored."""

    def __init__(self) -> None:
        self.stored = StoredHandOvers()
        self.is_full = False

    def store(self, memory: StoredHandOvers) -> None:
        if self.is_full:
            raise OSError(28, 'No space left on device')
        self.stored = memory


class Site:
    """A press that takes 3 s, and the part of the node that drives it."""

    def __init__(self, *faults: Tuple[FaultKind, float, float]) -> None:
        self.now = 0.0
        self.disk = Disk()
        self.press = SimulatedHandOver(lambda: self.now, 3.0,
                                       [ScriptedFault(*fault) for fault in faults])
        self.reports: List[StepReport] = []
        self.start()

    def start(self) -> None:
        self.devices = HandOvers(LIMITS, self.disk.stored, self.disk.store,
                                 7 + round(self.now), 0.1, self.now)

    def order(self, key: int, act: StepAct = StepAct.DO, kind: str = 'handshake',
              parameters: Sequence[Tuple[str, str]] = ()) -> None:
        self.devices.receive('press', StepCommand(key, act, self.run, kind, tuple(parameters)),
                             self.now)

    @property
    def run(self) -> int:
        return self.devices['press'].actor.run

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.1)):
            self.now += 0.1
            self.devices.tick(self.now)
            for name, start in self.devices.begin_due(self.now):
                try:
                    self.devices.ended(name, self.press.exchange(start), '', self.now)
                except Silent as silent:
                    self.devices.ended(name, None, str(silent), self.now)
            self.reports += [report for _, report in self.devices.reports(self.now)]

    def shown(self, key: int) -> Optional[ShownStep]:
        return self.reports[-1].find(key)

    def word(self, key: int) -> Optional[Word]:
        step = self.shown(key)
        return None if step is None else step.word


def test_a_press_hands_over_once_for_each_key():
    site = Site()
    for key in (4, 9):
        site.order(key)
        site.order(key)
        site.wait(2.0)
        assert site.word(key) is Word.RUNNING
        site.wait(4.0)
        site.order(key)
        site.wait(2.0)
        assert site.word(key) is Word.DONE
    assert site.press.done == [4, 9]


def test_a_driver_that_restarts_goes_on_with_its_run_and_its_reports_are_newer():
    site = Site()
    site.order(4)
    site.wait(1.5)
    before, run = site.reports[-1], site.run
    site.start()
    site.order(4)
    site.wait(5.0)
    assert (site.run, site.word(4), site.press.done) == (run, Word.DONE, [4])
    assert all(report.is_newer_than(before) for report in site.reports[-3:])


def test_a_driver_without_its_memory_begins_another_run_and_starts_nothing():
    site = Site()
    site.order(4)
    site.wait(1.5)
    run, site.disk.stored = site.run, StoredHandOvers()
    site.start()
    site.wait(5.0)
    assert site.run > run and site.reports[-1].steps == ()
    assert site.press.done == [4]


def test_nothing_starts_before_it_is_stored():
    site = Site()
    site.wait(1.0)
    site.disk.is_full = True
    site.order(4)
    site.wait(5.0)
    assert (site.word(4), site.press.done) == (None, [])
    assert 'No space left' in site.devices.problem
    site.disk.is_full = False
    site.order(4)
    site.wait(0.2)
    site.disk.is_full = True  # the device is READYING, and must not start
    site.wait(1.0)
    assert not site.press.exchange(None).start
    site.disk.is_full = False
    site.wait(5.0)
    assert site.word(4) is Word.DONE and not site.devices.problem


@pytest.mark.parametrize('fault, word, code', [
    ((FaultKind.FAILING, 0, ALWAYS), Word.FAILED, StepCode.OTHER),
    ((FaultKind.SILENT, 0, ALWAYS), Word.FAILED, StepCode.LOST_LINK),
    ((FaultKind.SILENT, 2, ALWAYS), Word.UNKNOWN, StepCode.LOST_LINK),
    ((FaultKind.LYING, 0, 20), Word.FAILED, StepCode.NOT_READY),
    ((FaultKind.SLOW, 0, ALWAYS), Word.DONE, StepCode.NONE)])
def test_each_fault_of_a_press_has_its_end(fault, word, code):
    site = Site(fault)
    site.order(4)
    site.wait(20.0)
    step = site.shown(4)
    assert step is not None and (step.word, step.code) == (word, code)


def test_a_press_that_never_ends_is_broken_off_and_it_is_not_known_how():
    site = Site((FaultKind.STUCK, 0, ALWAYS))
    site.order(4)
    site.wait(8.0)
    assert site.word(4) is Word.RUNNING
    site.order(4, StepAct.CANCEL)
    site.wait(8.0)
    assert site.word(4) is Word.UNKNOWN and not site.press.exchange(None).start


@pytest.mark.parametrize('kind, parameters, code', [
    ('engage', (), StepCode.UNKNOWN_TYPE),
    ('handshake', (('seconds', '3'),), StepCode.WRONG_PARAMETER)])
def test_a_step_that_no_device_has_fails(kind, parameters, code):
    site = Site()
    site.order(4, kind=kind, parameters=parameters)
    site.wait(1.0)
    step = site.shown(4)
    assert step is not None and (step.word, step.code) == (Word.FAILED, code)
