"""Files that people write: the table of actions and the vehicle's file."""
from __future__ import annotations

import pytest
from vda_builders import PACKAGE, abilities, table, vehicle_document

from vda5050_vehicle.core.action_table import WrongTable, read_table
from vda5050_vehicle.core.factsheet import WrongVehicle, check_vehicle

LINE = {'server': 'execute', 'type': 'some_msgs/Do', 'goal': {'text': 'do {what}'},
        'scopes': ['NODE'], 'parameters': {'what': {'type': 'STRING'}}}


def test_a_call_has_the_arguments_in_its_goal():
    spec = table().specs['say']
    assert spec.call.fields({'text': 'hello'}) == {'command': 'say hello'}


@pytest.mark.parametrize('document, words', [
    (None, 'actions:'), ({'actions': []}, 'actions:'), ({'actions': {'a': {}}}, 'server'),
    ({'actions': {'a': {**LINE, 'scopes': ['HERE']}}}, 'HERE'),
    ({'actions': {'a': {**LINE, 'blocking': ['MAYBE']}}}, 'MAYBE'),
    ({'actions': {'a': {**LINE, 'colour': 'red'}}}, 'colour'),
    ({'actions': {'a': {**LINE, 'parameters': {}}}}, 'what'),
    ({'actions': {'a': {**LINE, 'parameters': {'what': {'type': 'TEXT'}}}}}, 'TEXT'),
    ({'actions': {'a': {**LINE, 'parameters': {'what': {'typ': 'STRING'}}}}}, 'typ')])
def test_a_wrong_table_says_what_is_wrong(document, words):
    with pytest.raises(WrongTable, match=words):
        read_table(document)


@pytest.mark.parametrize('change', [
    lambda d: d.pop('agvGeometry'), lambda d: d['physicalParameters'].pop('speedMax'),
    lambda d: d['physicalParameters'].update(heightMax='low')])
def test_a_wrong_vehicle_file_says_what_is_wrong(change):
    document = vehicle_document()
    change(document)
    with pytest.raises(WrongVehicle):
        check_vehicle(document)


def test_the_packages_know_nothing_of_the_robot_but_its_tables():
    sources = '\n'.join(file.read_text() for file in PACKAGE.parent.glob('vda5050_*/src/**/*.py'))
    for word in ('omron', 'ld90', 'LD-90', 'execute_command', 'arcl'):
        found = [line for line in sources.splitlines() if word.lower() in line.lower()
                 and 'vehicle-type' not in line]
        assert not found, found
    assert abilities().top_speed == 1.35
