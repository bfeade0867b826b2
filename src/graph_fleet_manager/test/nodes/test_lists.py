"""The lists of missions and of closed edges fit a terminal; as JSON they have every field."""
from __future__ import annotations

import argparse
import json

import genpy
import pytest

from graph_fleet_manager.commands import edge, mission
from graph_fleet_manager.commands.mission_names import mission_name
from graph_fleet_manager.commands.tables import WIDTH, as_json, table, table_with_notes
from itrci_nav_msgs.msg import MissionStatus, StepParameter
from trajectory_graph import Edge, Graph, Vertex, split_edges

WORDS = 'it waits for a robot to be free, and none of the others has enough charge for it. '


@pytest.mark.parametrize('length', [1, 30, 200])
def test_a_table_fits_and_keeps_each_note_whole(length):
    rows = [('x' * length, 'short', 'y' * 40), ('a', 'b', 'c')]
    lines = table_with_notes(('one', 'two', 'three'), rows, [WORDS * 3, '']).splitlines()
    assert max(map(len, lines)) <= WIDTH
    assert lines[0].split() == ['one', 'two', 'three'] and lines[-1].split() == ['a', 'b', 'c']
    note = [line for line in lines if line.startswith('    ')]
    assert ' '.join(' '.join(note).split()) == (WORDS * 3).strip()
    assert 'short' in lines[1]


def test_a_table_without_a_width_cuts_nothing():
    assert table([('x' * 200, 'y')]) == 'x' * 200 + '  y'


def status(**fields):
    known = {'request_id': 7, 'state': MissionStatus.PENDING, 'reason': WORDS.strip(),
             'request_stamp': genpy.Time(1000)}
    return MissionStatus(**{**known, **fields})


def test_missions_are_listed_with_the_time_of_their_request_and_the_reason_below():
    active = status(request_id=2 ** 31 - 1, reason='', robot='ld90_1', state=MissionStatus.ACTIVE,
                    request_stamp=genpy.Time(0))
    listed = mission._listed([status(serial=42), active]).splitlines()
    assert listed[0].split() == ['mission', 'id', 'state', 'robot', 'reached', 'requested',
                                 'deadline']
    assert listed[1].split()[:5] == ['M42', '7', 'PENDING', '-', '0'] and '1970-01-0' in listed[1]
    assert listed[2].strip().startswith('it waits for a robot')
    assert listed[-1].split() == ['-', '2147483647', 'ACTIVE', 'ld90_1', '0', '-', '-']
    assert json.loads(as_json(mission._values(status(serial=42)))) == {
        'mission': 7, 'serial': 42, 'state': 'PENDING', 'robot': None, 'destinations_reached': 0,
        'reason': WORDS.strip(), 'requested': 1000.0, 'template': None, 'arguments': {},
        'earliest': None, 'deadline': None, 'deadline_state': 'NONE'}


@pytest.mark.parametrize('text, is_named', [
    ('7', (True, False)), ('M42', (True, True)), ('m42', (True, True)), ('42', (False, False)),
    ('M7', (False, False))])
def test_a_mission_is_named_by_its_id_or_by_its_short_name(text, is_named):
    name, other = mission_name(text), status(request_id=8, serial=42)
    assert (name.is_of(status(serial=42)), name.is_of(other)) == is_named
    assert str(name) == text.upper()


@pytest.mark.parametrize('text', ['', 'M', 'M0', 'M-1', 'M4.2', 'x', '1.5', '1_5', 'M' + '9' * 11])
def test_what_names_no_mission_is_refused(text):
    with pytest.raises(argparse.ArgumentTypeError, match='short name'):
        mission_name(text)


@pytest.mark.parametrize('code, alarm', [
    (MissionStatus.DEADLINE_AHEAD, []), (MissionStatus.DEADLINE_AT_RISK, ['AT', 'RISK']),
    (MissionStatus.DEADLINE_MISSED, ['MISSED'])])
def test_a_mission_is_listed_with_its_template_and_an_alarm_about_its_deadline(code, alarm):
    one = status(reason='', template='pallet', arguments=[StepParameter('to', '39')],
                 deadline=genpy.Time(5000), deadline_code=code)
    lines = mission._listed([one]).splitlines()
    assert lines[1].split()[-len(alarm) - 2:][2:] == alarm
    assert lines[2].strip() == 'pallet to:=39'
    values = mission._values(one)
    assert (values['template'], values['arguments'], values['deadline']) == (
        'pallet', {'to': '39'}, 5000.0)


def test_a_closed_edge_is_listed_once_as_it_was_drawn():
    graph = split_edges(Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 6.0, 0.0, 0.0)],
                              [Edge(7, 1, 2), Edge(8, 2, 1)]), 2.0)
    closed = edge._closed(graph, graph.whole_edges((7,)))
    assert closed == [{'edge': 7, 'from': 1, 'to': 2, 'length': pytest.approx(6.0)}]
    lines = edge._listed(closed, []).splitlines()
    assert lines[0].split() == ['closed', 'edge', 'from', 'to', 'length']
    assert lines[1].split() == ['7', '1', '2', '6.0', 'm']
    assert edge._listed([], []) == 'No edge is closed.'
