"""If a new graph does not fit the work file, nothing is granted on the old graph any more."""
from __future__ import annotations

from types import SimpleNamespace
from typing import Any, List, Optional

import pytest
from fleet_builders import AGV, corridor

from fleet_core.fleet import Fleet
from fleet_core.supervision.missions import Request
from graph_fleet_manager.nodes import path_supervisor, work_file
from graph_fleet_manager.nodes.event_loop import SupervisorEvents

NOW = 100.0


def node(supervisor: Optional[Any], graph: Any) -> path_supervisor.PathSupervisor:
    """Returns path_supervisor without ROS, which has just got this graph."""
    made = object.__new__(path_supervisor.PathSupervisor)
    made._supervisor, made._graph, made._closed, made._begin_at = supervisor, graph, (), NOW
    made._file = SimpleNamespace(open=lambda now: None, journal=object())
    made._early = SimpleNamespace(due=lambda now: ())
    made._work_file = work_file.WorkFile(Fleet((), ()))
    made._events = SupervisorEvents(lambda: NOW)
    return made


@pytest.fixture
def wrong_file(tmp_path, monkeypatch):
    file = tmp_path / 'work.yaml'
    file.write_text('stations: [{name: press, places: [99]}]')
    monkeypatch.setattr(work_file, 'parameter', lambda *_: str(file))


def test_the_supervisor_of_the_former_graph_ends_if_the_work_file_does_not_fit_the_new_one(
        wrong_file):
    begun = node(SimpleNamespace(trouble=''), corridor(3))
    begun._events.begin()
    assert begun._begin(NOW) == ()
    assert begun._supervisor is None and 'no vertex 99' in begun._work_file.trouble
    begun._events.put_request(Request(1, (3,)))
    begun._events.next_event()(begun._supervisor, NOW)  # a tick: the request waits
    assert begun._events._requests


def test_a_supervisor_that_could_not_store_its_changes_stays_until_it_can(wrong_file):
    begun = node(SimpleNamespace(trouble='no space is left'), corridor(3))
    begun._begin(NOW)
    assert begun._supervisor is not None and not begun._work_file.trouble


def test_a_place_that_keeps_robots_from_their_loads_is_told_once(tmp_path, monkeypatch):
    file = tmp_path / 'work.yaml'
    file.write_text('''stations: [{name: press, places: [2], queue: [3]}]
loads: [{name: pallet, footprint: {radius: 1.7}}]
templates:
- name: fetch
  stops: [{at: press, steps: [{type: take, timeout: 60, load: takes, load_type: pallet}]}]
''')
    told: List[str] = []
    monkeypatch.setattr(work_file, 'parameter', lambda *_: str(file))
    monkeypatch.setattr(work_file.rospy, 'logwarn', lambda text, *values: told.append(
        text % values))
    read = work_file.WorkFile(Fleet((AGV,), ())).read
    assert read(corridor(3)) is not None and read(corridor(3)) is not None
    assert [text.startswith(f'{file}: queue place 3 of station press is 2.00 m from vertex 2')
            for text in told] == [True]
