"""Requests and reports of devices are converted to messages and back without a change."""
from __future__ import annotations

import genpy
import pytest

from itrci_nav_msgs import msg
from route_protocol.device_messages import (
    LONGEST_NAME,
    MOST_USES,
    WrongDeviceMessage,
    device_report_of,
    device_request_of,
    fill_device_report,
    fill_device_request,
)
from route_protocol.devices import (
    DeviceFault,
    DeviceMode,
    DeviceReport,
    DeviceRequest,
    DeviceUse,
)

REQUESTED = (DeviceMode.OPEN, DeviceMode.CLOSED)
READABLE = {'device_name': 'gate', 'current_mode': 2}


def message_of(report: DeviceReport) -> msg.DeviceState:
    return fill_device_report(msg.DeviceState(), report, msg.DeviceUse, genpy.Time.from_sec)


@pytest.mark.parametrize('mode', REQUESTED)
def test_a_request_comes_back(mode):
    request = DeviceRequest('fleet', 'gate', mode, 2 ** 60)
    assert device_request_of(fill_device_request(msg.DeviceRequest(), request)) == request


@pytest.mark.parametrize('mode', DeviceMode)
@pytest.mark.parametrize('read_at', [None, 3.5])
def test_a_report_comes_back(mode, read_at):
    obeyed = tuple(DeviceUse(f'robot {k}', wanted, 2 ** 60 + k, 2.25)
                 for k, wanted in enumerate(REQUESTED))
    for fault in DeviceFault:
        report = DeviceReport('gate', mode, 1.5, read_at, obeyed, fault, 'why', 2 ** 61, 7)
        assert device_report_of(message_of(report)) == report


def test_the_constants_of_the_messages_are_those_of_the_values():
    for enum, message in ((DeviceMode, msg.DeviceState), (DeviceFault, msg.DeviceState),
                          (REQUESTED, msg.DeviceRequest)):
        assert {one.name: int(one) for one in enum} == {
            one.name: getattr(message, one.name) for one in enum}


@pytest.mark.parametrize('name', ['', ' ', 'a\nb', 'a\x1b[2J', 'x' * (LONGEST_NAME + 1)])
@pytest.mark.parametrize('field', ['requester_id', 'device_name'])
def test_a_name_that_cannot_be_read_is_refused(name, field):
    given = {'requester_id': 'fleet', 'device_name': 'gate', 'requested_mode': 2, field: name}
    with pytest.raises(WrongDeviceMessage, match=field):
        device_request_of(msg.DeviceRequest(**given))


@pytest.mark.parametrize('mode', [1, 3, 4, 255])
def test_only_open_and_closed_can_be_requested(mode):
    with pytest.raises(WrongDeviceMessage, match=f'requested_mode is {mode}'):
        device_request_of(msg.DeviceRequest(requester_id='a', device_name='b',
                                            requested_mode=mode))
    with pytest.raises(WrongDeviceMessage, match=f'requested_mode is {mode}'):
        device_report_of(msg.DeviceState(
            obeyed=[msg.DeviceUse(requester_id='a', requested_mode=mode)], **READABLE))


@pytest.mark.parametrize('field', ['current_mode', 'fault'])
def test_an_unknown_number_is_refused(field):
    with pytest.raises(WrongDeviceMessage, match='does not exist'):
        device_report_of(msg.DeviceState(**{**READABLE, field: 99}))


def test_a_report_of_too_many_uses_is_refused_and_a_reason_is_printable():
    use = msg.DeviceUse(requester_id='a', requested_mode=2)
    with pytest.raises(WrongDeviceMessage, match=f'more than {MOST_USES}'):
        device_report_of(msg.DeviceState(obeyed=[use] * (MOST_USES + 1), **READABLE))
    report = device_report_of(msg.DeviceState(reason='a\n' * 999, **READABLE))
    assert report.reason == 'a?' * 250
