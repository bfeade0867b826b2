"""The bridge's record is read unchanged by the next bridge; wrong content is rejected."""
from __future__ import annotations

import json
import math
import threading
from dataclasses import replace
from typing import Any, Iterator, List

import pytest
import rospy

from omron_ld90.bridge.events import BridgeMemory
from omron_ld90.nodes import bridge_memory
from omron_ld90.nodes.bridge_memory import PARAMETER, RouteMemory
from omron_ld90.nodes.support.boot_clock import Moment
from route_protocol.values import (
    EMERGENCY_STOP,
    LARGEST_NUMBER,
    LARGEST_RECORD_NUMBER,
    OVERRULED,
    EpochCause,
    Phase,
    RouteOrder,
)
from route_protocol.vehicle import VehicleState

RECORD = BridgeMemory(
    VehicleState(LARGEST_NUMBER, EpochCause.OTHER_MASTER, '/fleet', LARGEST_NUMBER - 1,
                 LARGEST_NUMBER - 2, OVERRULED, LARGEST_RECORD_NUMBER - 1, 7,
                 LARGEST_RECORD_NUMBER - 2, (1, -4, 5), Phase.RUNNING, report=LARGEST_NUMBER - 3),
    target=2, number=LARGEST_NUMBER - 1, owes_stop=False, epoch=LARGEST_NUMBER,
    last=RouteOrder(7, (1, -4, 5), 1_700_000_000_123_456_789))
ENDED = BridgeMemory(VehicleState(5, route_id=8, edges=(3,), phase=Phase.FAILED,
                                  reason=EMERGENCY_STOP), owes_stop=True)


class Parameters:
    """A ROS master that keeps one parameter, and can fail to answer."""

    def __init__(self) -> None:
        self.content: Any = None
        self.failures: List[Exception] = []
        self.written = threading.Semaphore(0)
        self.memories: List[RouteMemory] = []

    def memory(self, launch: str = 'launch_1', file: object = '') -> RouteMemory:
        """Returns the memory of a bridge that this launch has just started."""
        self.memories.append(RouteMemory(launch, str(file)))
        return self.memories[-1]

    def get(self, name: str, default: Any) -> Any:
        assert name == PARAMETER
        return default if self.content is None else json.dumps(self.content)

    def set(self, name: str, content: str) -> None:
        assert name == PARAMETER
        if self.failures:
            raise self.failures.pop()
        self.content = json.loads(content)
        self.written.release()


@pytest.fixture
def parameters(monkeypatch) -> Iterator[Parameters]:
    master = Parameters()
    monkeypatch.setattr(rospy, 'get_param', master.get)
    monkeypatch.setattr(rospy, 'set_param', master.set)
    monkeypatch.setattr(rospy, 'logwarn_throttle', lambda *_: None)
    monkeypatch.setattr(bridge_memory, 'REFRESHED', 0.05)
    yield master
    for memory in master.memories:
        memory.close()


@pytest.mark.parametrize('record', [RECORD, ENDED], ids=['running', 'ended'])
def test_a_record_comes_back_with_its_age(parameters, record):
    memory = parameters.memory()
    memory.keep(record)
    memory.close()
    recalled, age, is_sure = parameters.memory().recall()
    assert recalled == record
    assert recalled.vehicle.report == record.vehicle.report
    assert 0.0 <= age < 10.0
    assert is_sure


def test_no_clock_that_is_set_makes_a_record_younger(parameters, monkeypatch):
    """Once, the bridge continued a route that was hours old: the clock was set back after a power
    cut.
    """
    memory = parameters.memory()
    memory.keep(RECORD)
    memory.close()
    now = Moment.now()
    for later, age in (
            (now._replace(wall=now.wall - 1e6), 0.0),
            (now._replace(wall=now.wall + 1e6), 0.0),
            (now._replace(since_boot=now.since_boot + 3600.0, wall=now.wall - 1e6), 3600.0),
            (Moment('another boot', 30.0, now.wall - 5.0), math.inf),
            (Moment('another boot', 30.0, now.wall + 5.0), 30.0),
            (Moment('another boot', 30.0, now.wall + 50.0), 50.0)):
        monkeypatch.setattr(bridge_memory.Moment, 'now', lambda later=later: later)
        recalled = parameters.memory().recall()
        assert recalled.age == pytest.approx(age, abs=10.0)
        assert recalled.is_sure is (later.boot == now.boot)


def test_a_record_of_another_launch_is_too_old_to_be_gone_on_with(parameters):
    memory = parameters.memory('launch_1')
    memory.keep(RECORD)
    memory.close()
    assert parameters.memory('launch_2').recall() == (RECORD, math.inf, True)


def test_without_a_record_there_is_none(parameters):
    assert parameters.memory().recall() is None


@pytest.mark.parametrize('content', [
    7, 'route', [], {}, {'time': 1.0}, {'time': 'noon', 'route_id': 7},
], ids=str)
def test_what_is_no_record_is_none(parameters, content):
    parameters.content = content
    assert parameters.memory().recall() is None


def test_a_master_that_does_not_answer_is_told_again_with_the_next_record(parameters):
    memory = parameters.memory()
    parameters.failures.append(ConnectionRefusedError())
    memory.keep(RECORD)
    memory.keep(ENDED)
    assert parameters.written.acquire(timeout=10.0)
    while parameters.content['record']['vehicle']['route_id'] != ENDED.vehicle.route_id:
        assert parameters.written.acquire(timeout=10.0)
    assert memory.recall().record == ENDED


def test_the_file_is_written_before_the_robot_acts(parameters, tmp_path, monkeypatch):
    """If the bridge dies at once, it must not obey an older order after its restart."""
    file = tmp_path / 'route.json'
    memory = parameters.memory(file=file)
    monkeypatch.setattr(rospy, 'set_param', lambda *_: None)
    for record in (RECORD, ENDED):
        memory.keep(record)
        assert parameters.memory(file=file).recall().record == record


def test_the_number_of_the_last_report_is_kept_though_it_alone_makes_no_new_record(parameters):
    memory = parameters.memory()
    memory.keep(RECORD)
    later = replace(RECORD, vehicle=replace(RECORD.vehicle, report=LARGEST_NUMBER))
    memory.keep(later)
    memory.close()
    assert parameters.memory().recall().record.vehicle.report == LARGEST_NUMBER


def test_a_file_outlives_the_master(parameters, tmp_path):
    file = tmp_path / 'folder' / 'route.json'
    before = parameters.memory(file=file)
    before.keep(RECORD)
    before.close()
    parameters.content = None
    recalled, age, _ = parameters.memory(file=file).recall()
    assert recalled == RECORD
    assert 0.0 <= age < 10.0


def test_of_parameter_and_file_the_later_counts(parameters, tmp_path):
    file = tmp_path / 'route.json'
    for record in (RECORD, ENDED):
        memory = parameters.memory(file=file)
        memory.keep(record)
        memory.close()
        if record is RECORD:
            before = file.read_text()
    file.write_text(before)
    assert parameters.memory(file=file).recall().record == ENDED
    parameters.content = {**parameters.content, 'since_boot': 0.5}
    assert parameters.memory(file=file).recall().record == RECORD


@pytest.mark.parametrize('text', ['', '{', '[]', '7', '{"time": 1}'])
def test_a_file_that_holds_no_record_is_none(parameters, tmp_path, text):
    file = tmp_path / 'route.json'
    file.write_text(text)
    assert parameters.memory(file=file).recall() is None


def test_a_relative_path_begins_in_ros_home(parameters, tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    memory = parameters.memory(file='omron_ld90/r_route.json')
    memory.keep(RECORD)
    memory.close()
    assert (tmp_path / 'omron_ld90' / 'r_route.json').exists()


def test_a_file_that_cannot_be_written_leaves_the_parameter(parameters, tmp_path):
    (tmp_path / 'file').write_text('')
    memory = parameters.memory(file=tmp_path / 'file' / 'route.json')
    memory.keep(RECORD)
    memory.close()
    assert memory.recall().record == RECORD


@pytest.mark.parametrize('ended', [False, True], ids=['died', 'ended by a person'])
def test_a_launch_is_gone_on_with_by_another_only_where_it_died(parameters, tmp_path, ended):
    file = tmp_path / 'route.json'
    memory = parameters.memory('launch_1', file)
    memory.keep(RECORD)
    assert parameters.written.acquire(timeout=10.0)
    if ended:
        memory.close()
    left = file.read_text(), parameters.content
    memory.close()
    file.write_text(left[0])
    parameters.content = left[1]
    record, age, _ = parameters.memory('launch_2', file).recall()
    assert (record, math.isinf(age)) == (RECORD, ended)
