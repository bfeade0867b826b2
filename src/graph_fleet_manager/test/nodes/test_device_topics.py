"""path_supervisor sends requests to devices, and gets their reports, in messages of fleet_devices.
"""
from __future__ import annotations

import time
from typing import Any, Callable, Dict, List, Tuple

import pytest
import rospy

from fleet_core.interlocking.route_master import ME
from fleet_core.interlocking.stop_gate import StopGate
from fleet_core.supervision.actions import AskDevice
from graph_fleet_manager.nodes import fleet_topics
from graph_fleet_manager.nodes.path_supervisor import PathSupervisor
from itrci_nav_msgs.msg import DeviceState
from itrci_nav_msgs.msg import DeviceUse as Use
from route_protocol.device_messages import device_request_of
from route_protocol.devices import DeviceMode, DeviceReport, DeviceRequest


class Publisher:
    """Keeps what is published on each topic."""

    sent: Dict[str, List[Any]] = {}

    def __init__(self, topic: str, *_: Any, **__: Any) -> None:
        self.publish: Callable[[Any], None] = self.sent.setdefault(topic, []).append


def test_a_request_to_a_device_is_published_as_fleet_devices_reads_it(
        monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fleet_topics.rospy, 'Publisher', Publisher)
    monkeypatch.setattr(fleet_topics.rospy.Time, 'now', lambda: rospy.Time(5))
    monkeypatch.setattr(Publisher, 'sent', {})
    topics = fleet_topics.FleetTopics((), 1.0, 0.0, print, StopGate())
    request = DeviceRequest(ME, 'gate', DeviceMode.OPEN, 2 ** 41)
    topics.do([AskDevice(request)])
    message, = Publisher.sent['/device_request']
    assert (device_request_of(message), message.request_time) == (request, rospy.Time(5))


class Events:
    """Keeps the newest report for each key, like `SupervisorEvents`."""

    def __init__(self) -> None:
        self.reports: Dict[str, Callable[..., Any]] = {}

    def put_report(self, event: Callable[..., Any], key: str) -> None:
        self.reports[key] = event


class HearingSupervisor:
    """A supervisor that keeps the reports of devices, and the times when they came."""

    def __init__(self) -> None:
        self.heard: List[Tuple[DeviceReport, float]] = []

    def device_report(self, report: DeviceReport, now: float) -> Tuple[()]:
        self.heard.append((report, now))
        return ()


@pytest.fixture
def heard(monkeypatch: pytest.MonkeyPatch) -> Callable[..., List[Tuple[DeviceReport, float]]]:
    """Returns the reports that a supervisor gets from messages that arrive at ROS time 1000 s."""
    def hear(*messages: DeviceState) -> List[Tuple[DeviceReport, float]]:
        node, supervisor = object.__new__(PathSupervisor), HearingSupervisor()
        node._events = Events()
        for message in messages:
            node._on_device(message)
        for event in node._events.reports.values():
            event(supervisor, time.monotonic(), time.monotonic())
        return supervisor.heard
    monkeypatch.setattr(rospy, 'get_time', lambda: 1000.0)
    return hear


def state(name: str = 'gate', **fields: Any) -> DeviceState:
    return DeviceState(device_name=name, current_mode=DeviceState.OPEN, obeyed=[
        Use(ME, DeviceState.OPEN, 7, rospy.Time(990))], **fields)


def test_a_reading_has_its_age_by_the_clock_of_the_supervisor(
        heard: Callable[..., List[Tuple[DeviceReport, float]]]) -> None:
    (report, now), = heard(state(device_time=rospy.Time(998), count=3))
    assert report.read_at == pytest.approx(now - 2.0, abs=0.5)
    assert (report.mode, report.count) == (DeviceMode.OPEN, 3)
    assert report.is_open_for(ME, 7)


def test_a_device_that_was_never_read_has_no_reading(
        heard: Callable[..., List[Tuple[DeviceReport, float]]]) -> None:
    (report, _), = heard(state())
    assert report.read_at is None


def test_only_the_newest_report_of_each_device_waits(
        heard: Callable[..., List[Tuple[DeviceReport, float]]]) -> None:
    told = heard(state(count=1), state('lamp', count=2), state(count=3))
    assert sorted((report.device, report.count) for report, _ in told) == [
        ('gate', 3), ('lamp', 2)]


def test_a_message_that_is_no_report_is_ignored(
        heard: Callable[..., List[Tuple[DeviceReport, float]]],
        monkeypatch: pytest.MonkeyPatch) -> None:
    told: List[str] = []
    monkeypatch.setattr(rospy, 'logwarn_throttle', lambda _, text: told.append(text))
    assert not heard(state(''), DeviceState(device_name='gate', current_mode=99))
    assert ['device_name' in told[0], 'its mode or fault' in told[1]] == [True, True]
