"""Planted faults: each function leaves out one rule of a device until the test ends."""
from __future__ import annotations

from dataclasses import replace
from typing import Callable

import pytest

from fleet_devices.core import device as rules
from fleet_devices.core.device import DeviceLimits, DeviceMachine, Stage
from route_protocol.devices import DeviceMode


def forgets_no_number(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(DeviceMachine, '_is_new', staticmethod(lambda request, use: True))


def believes_one_reading(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(rules, 'STEADY', 1)


def believes_readings_that_differ(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(DeviceMachine, '_continues', lambda self, settled: True)


def shows_what_was_not_read(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(DeviceMachine, '_is_read', lambda self, taken: True)


def changed(patch: pytest.MonkeyPatch, name: str,
            change: Callable[[DeviceMachine, DeviceMachine], DeviceMachine]) -> None:
    """Replaces the result of an event by the result of `change`.

    change -- gets the state before the event, and the right result
    """
    right = getattr(DeviceMachine, name)

    def wrong(self: DeviceMachine, *arguments: object) -> DeviceMachine:
        return change(self, right(self, *arguments))
    patch.setattr(DeviceMachine, name, wrong)


def keeps_readings_over_a_silence(patch: pytest.MonkeyPatch) -> None:
    changed(patch, 'tick', lambda before, after: replace(after, alike=before.alike)
            if after.mode is DeviceMode.OFFLINE else after)


def keeps_readings_over_a_stage(patch: pytest.MonkeyPatch) -> None:
    right = DeviceMachine._with

    def wrong(self: DeviceMachine, now: float, **changes: object) -> DeviceMachine:
        after = right(self, now, **changes)
        return replace(after, alike=self.alike, stage_from=self.stage_from).tick(now)
    patch.setattr(DeviceMachine, '_with', wrong)


def believes_an_output_that_was_not_read(patch: pytest.MonkeyPatch) -> None:
    changed(patch, 'end', lambda before, after: replace(after, output=before.output)
            if after.problem else after)


def is_never_offline(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(DeviceLimits, 'offline_after', 10 ** 9)


def closes_after_a_start(patch: pytest.MonkeyPatch) -> None:
    right = DeviceMachine.start.__func__  # type: ignore[attr-defined]
    patch.setattr(DeviceMachine, 'start', classmethod(
        lambda cls, *arguments: replace(right(cls, *arguments), is_closing=True)))


def forgets_that_the_memory_is_lost(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(DeviceMachine, 'stage', property(
        lambda self: Stage.HELD if any(one.use.holds for one in self.obeyed) else
        Stage.CLOSING if self.is_closing else Stage.LEFT))


def closes_for_the_first_who_gives_back(patch: pytest.MonkeyPatch) -> None:
    right = DeviceMachine.stage.fget  # type: ignore[attr-defined]
    patch.setattr(DeviceMachine, 'stage', property(
        lambda self: Stage.CLOSING if self.is_closing and not self.is_memory_lost
        else right(self)))


def ends_a_use_by_time(patch: pytest.MonkeyPatch) -> None:
    """A use ends after some time (a lease), although a robot may still be in the door."""
    changed(patch, 'tick', lambda before, after: replace(after, obeyed=(), is_closing=True)
            if before.obeyed and after.fault is not before.fault else after)


def opens_once_only(patch: pytest.MonkeyPatch) -> None:
    right = DeviceMachine.begin

    def wrong(self: DeviceMachine, now: float) -> object:
        after, exchange = right(self, now)
        return after, exchange if self.read == 0 else exchange._replace(output=None)
    patch.setattr(DeviceMachine, 'begin', wrong)


def never_closes(patch: pytest.MonkeyPatch) -> None:
    patch.setitem(rules._OUTPUT, Stage.CLOSING, None)
