from pathlib import Path

import pytest

from fleet_core.files.errors import FileError
from fleet_simulation.demand_file import load_demand


def wanted(folder: Path, graph, text: str):
    path = folder / 'demand.yaml'
    path.write_text(text)
    return load_demand(path, graph)


def test_so_many_missions_come_as_the_flow_has_an_hour_and_the_same_of_the_same_seed(
        yard, tmp_path) -> None:
    demand = wanted(tmp_path, yard, 'groups: {all: [21, 22, 23]}\n'
                                    'flows:\n- {from: 25, to: all, per_hour: 100}\n').demand
    drawn = demand.draw(3, 10.0)
    assert drawn == demand.draw(3, 10.0) != demand.draw(4, 10.0)
    assert 900 < len(drawn) < 1100
    assert {request.destinations for request in drawn} == {(25, 21), (25, 22), (25, 23)}


def test_missions_come_in_their_shifts_only(yard, tmp_path) -> None:
    demand = wanted(tmp_path, yard, 'flows:\n- to: 21\n  timetable:\n'
                                    '  - {begin: 1, end: 2, per_hour: 50}\n').demand
    assert all(3600.0 <= request.stamp < 7200.0 for request in demand.draw(1, 8.0))


def test_a_recorded_day_is_driven_as_it_was(yard, tmp_path) -> None:
    (tmp_path / 'day.csv').write_text('time,destinations,priority\n12.5,21 25,3\n3,22,0\n')
    drawn = wanted(tmp_path, yard, 'csv: day.csv\n').demand.draw(1, 1.0)
    assert [(one.stamp, one.destinations, one.priority) for one in drawn] == [
        (3.0, (22,), 0), (12.5, (21, 25), 3)]


@pytest.mark.parametrize(('text', 'line', 'problem'), [
    ('flows:\n- {to: 99, per_hour: 3}\n', 2, 'to is 99, but the graph has no vertex 99'),
    ('flows:\n- {to: yard, per_hour: 3}\n', 2,
     "to is 'yard', which is neither a vertex nor a group; there are no groups"),
    ('flows:\n- {to: 21, per_huor: 3}\n', 2,
     "a flow has the unknown key 'per_huor'; did you mean per_hour?"),
    ('flows:\n- {to: 21}\n', 2, 'a flow needs exactly one of per_hour, timetable and saturated'),
    ('flows:\n- {from: 21, to: 21, per_hour: 3}\n', 2, 'a flow leads from vertex 21 to itself'),
    ('flows:\n- to: 21\n  timetable:\n  - {begin: 3, end: 2, per_hour: 1}\n', 4,
     'a shift ends at 2 h, which is not after its begin at 3 h'),
    ('flows:\n- {to: 21, per_hour: -1}\n', 2,
     'per_hour is -1, but must be a number from 0 to 100000'),
    ('groups: {}\n', 1, 'the demand has no missions: give flows or csv'),
])
def test_what_is_wrong_is_one_sentence_with_its_line(yard, tmp_path, text, line, problem) -> None:
    with pytest.raises(FileError) as error:
        wanted(tmp_path, yard, text)
    assert (error.value.line, error.value.problem) == (line, problem)


def test_a_wrong_line_of_a_csv_is_named(yard, tmp_path) -> None:
    (tmp_path / 'day.csv').write_text('time,destinations\n1,21\n2,77\n')
    with pytest.raises(FileError) as error:
        wanted(tmp_path, yard, 'csv: day.csv\n')
    assert str(error.value) == f'{tmp_path}/day.csv, line 3: the graph has no vertex 77.'
