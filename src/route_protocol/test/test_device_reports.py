"""The numbers in reports show a requester that its request was taken and that a report is new."""
from __future__ import annotations

import pytest

from route_protocol.devices import DeviceMode, DeviceReport, DeviceRequest, DeviceUse

USE = DeviceUse('fleet', DeviceMode.OPEN, 5, 1.0)


def report(*obeyed: DeviceUse, mode: DeviceMode = DeviceMode.OPEN, run: int = 1,
           count: int = 1) -> DeviceReport:
    return DeviceReport('gate', mode, 0.0, 2.0, obeyed, run=run, count=count)


@pytest.mark.parametrize('number, is_shown', [(4, True), (5, True), (6, False)])
@pytest.mark.parametrize('mode', [DeviceMode.OPEN, DeviceMode.CLOSED])
def test_a_request_is_repeated_until_its_number_is_shown(number, is_shown, mode):
    assert report(USE).shows(DeviceRequest('fleet', 'gate', mode, number)) is is_shown
    assert not report(USE).shows(DeviceRequest('other', 'gate', mode, 1))


@pytest.mark.parametrize('requester, number, mode, is_open', [
    ('fleet', 5, DeviceMode.OPEN, True),
    ('fleet', 6, DeviceMode.OPEN, False),     # its newest request was not taken yet
    ('fleet', 4, DeviceMode.OPEN, False),     # another program of the same name has requested
    ('other', 5, DeviceMode.OPEN, False),
    *(('fleet', 5, mode, False) for mode in DeviceMode if mode is not DeviceMode.OPEN)])
def test_a_device_is_open_only_for_whom_it_obeys(requester, number, mode, is_open):
    assert report(USE, mode=mode).is_open_for(requester, number) is is_open


def test_a_device_is_not_open_for_one_who_gave_it_back():
    given_back = DeviceUse('fleet', DeviceMode.CLOSED, 5, 1.0)
    assert not report(given_back).is_open_for('fleet', 5)


def test_reports_are_newer_by_run_and_then_by_count():
    reports = [report(run=run, count=count) for run in (1, 2) for count in (1, 2)]
    for k, one in enumerate(reports):
        assert one.is_newer_than(None)
        assert [one.is_newer_than(other) for other in reports] == [k > m for m in range(4)]
