"""Converts requests and reports of devices to and from messages of `itrci_nav_msgs`.

Only this module uses the fields of these messages. It does not import ROS.
"""
from __future__ import annotations

from typing import Any, Callable, Type

from route_protocol.devices import (
    DeviceFault,
    DeviceMode,
    DeviceReport,
    DeviceRequest,
    DeviceUse,
)

MOST_USES = 200      # maximum number in one report; a report with more uses is refused
LONGEST_NAME = 100   # maximum number of letters in the name of a device or requester
_LONGEST_TEXT = 500  # maximum number of letters of a reason that are kept

_REQUESTED = (DeviceMode.CLOSED, DeviceMode.OPEN)


class WrongDeviceMessage(ValueError):
    """A message that cannot be used. The text of the error is a clause that says why."""


def device_request_of(message: Any) -> DeviceRequest:
    """Returns the request in an `itrci_nav_msgs/DeviceRequest`. Raises WrongDeviceMessage."""
    return DeviceRequest(_name('requester_id', message.requester_id),
                         _name('device_name', message.device_name),
                         _requested(message.requested_mode), message.number)


def fill_device_request(message: Any, request: DeviceRequest) -> Any:
    """Fills an empty `itrci_nav_msgs/DeviceRequest`, except its time, and returns it."""
    message.requester_id, message.device_name = request.requester, request.device
    message.requested_mode, message.number = int(request.mode), request.number
    return message


def device_report_of(message: Any) -> DeviceReport:
    """Returns the report in an `itrci_nav_msgs/DeviceState`. Raises WrongDeviceMessage."""
    if len(message.obeyed) > MOST_USES:
        raise WrongDeviceMessage(f'it has more than {MOST_USES} uses')
    try:
        mode, fault = DeviceMode(message.current_mode), DeviceFault(message.fault)
    except ValueError as error:
        raise WrongDeviceMessage(f'its mode or fault does not exist ({error})') from None
    obeyed = tuple(DeviceUse(_name('requester_id', one.requester_id),
                           _requested(one.requested_mode), one.number, one.since.to_sec())
                 for one in message.obeyed)
    return DeviceReport(
        _name('device_name', message.device_name), mode, message.since.to_sec(),
        message.device_time.to_sec() or None, obeyed, fault,
        _printable(message.reason[:_LONGEST_TEXT]), message.run, message.count)


def fill_device_report(message: Any, report: DeviceReport, use_type: Type[Any],
                       time_of: Callable[[float], Any]) -> Any:
    """Fills an empty `itrci_nav_msgs/DeviceState` and returns it.

    use_type -- the message type of `obeyed`
    time_of  -- makes the time of a message from a time in s
    """
    message.device_name, message.current_mode = report.device, int(report.mode)
    message.since, message.device_time = time_of(report.since), time_of(report.read_at or 0.0)
    message.obeyed = [use_type(use.requester, int(use.mode), use.number, time_of(use.since))
                    for use in report.obeyed]
    message.fault, message.reason = int(report.fault), report.reason
    message.run, message.count = report.run, report.count
    return message


def _requested(number: int) -> DeviceMode:
    if number not in _REQUESTED:
        raise WrongDeviceMessage(f'its requested_mode is {number}, but must be CLOSED '
                                 f'({int(DeviceMode.CLOSED)}) or OPEN ({int(DeviceMode.OPEN)})')
    return DeviceMode(number)


def _name(field: str, text: str) -> str:
    """Returns a name. A name must be readable, because it is compared and shown."""
    if not text.strip() or not text.isprintable() or len(text) > LONGEST_NAME:
        raise WrongDeviceMessage(f'its {field} is empty, has more than {LONGEST_NAME} letters, or '
                                 'letters that cannot be printed')
    return text


def _printable(text: str) -> str:
    return ''.join(letter if letter.isprintable() else '?' for letter in text)
