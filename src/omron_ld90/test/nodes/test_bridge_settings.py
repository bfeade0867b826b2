"""The bridge uses its parameters in m, s and m/s; a wrong parameter gives a clear message."""
from __future__ import annotations

from dataclasses import fields
from typing import Any, Dict, Optional

import pytest
import rospy

from node_lifecycle import ConfigurationError
from omron_ld90.bridge.route_strategies import STRATEGIES, RouteSettings
from omron_ld90.nodes.bridge_settings import read_settings
from trajectory_graph import Edge, Graph, Vertex

DOCK = 47
GRAPH = Graph([Vertex(DOCK, 0.0, 0.0, 0.0), Vertex(12, 1.0, 0.0, 0.0)], [Edge(1, 12, DOCK)])
# the smallest and the largest value of each number
LIMITS = {
    'vertex_tolerance': (0.05, 2.0), 'corridor_width': (0.3, 10.0), 'stall_timeout': (1.0, 3600.0),
    'location_timeout': (0.5, 60.0), 'link_timeout': (0.0, 60.0), 'restart_timeout': (0.0, 600.0),
    'top_speed': (0.1, 10.0), 'acceleration': (0.05, 10.0), 'braking': (0.05, 10.0)}


@pytest.fixture
def given(monkeypatch) -> Dict[str, Any]:
    """Returns the parameters of the node, by their names without `~`."""
    values: Dict[str, Any] = {}
    monkeypatch.setattr(rospy, 'get_param', lambda name, default: values.get(name[1:], default))
    monkeypatch.setattr(rospy, 'resolve_name', lambda name: f'/bridge/{name[1:]}')
    return values


def message(graph: Optional[Graph] = GRAPH) -> str:
    """Reads wrong settings. Returns the text of the error."""
    with pytest.raises(ConfigurationError) as wrong:
        read_settings(graph)
    return str(wrong.value)


@pytest.mark.parametrize('graph', [GRAPH, None])
def test_without_parameters_they_are_those_of_the_class(given, graph):
    assert read_settings(graph) == RouteSettings()


def test_every_number_of_the_settings_can_be_given(given):
    others = {'dock_vertex', 'strategy', 'native_command'}
    assert {field.name for field in fields(RouteSettings)} == others | set(LIMITS)


@pytest.mark.parametrize('name', LIMITS)
def test_a_number_is_taken_as_it_is_up_to_its_limits(given, name):
    for value in (*LIMITS[name], 1):
        given.clear()
        given[name] = value
        settings = read_settings(GRAPH)
        assert getattr(settings, name) == value
        unchanged = {field.name: getattr(RouteSettings(), field.name)
                     for field in fields(RouteSettings)
                     if field.name != name}
        assert unchanged.items() <= vars(settings).items()


@pytest.mark.parametrize('name', LIMITS)
@pytest.mark.parametrize(('end', 'beyond'), [(0, -0.01), (1, 0.01)])
def test_a_number_beyond_its_limits_is_told_with_them(given, name, end, beyond):
    least, greatest = LIMITS[name]
    given[name] = LIMITS[name][end] + beyond
    assert message() == (f'Parameter /bridge/{name} is {given[name]}, but must lie in '
                         f'{least}..{greatest}.')


@pytest.mark.parametrize('value', ['0.3', True, [0.3], float('nan'), float('inf')])
@pytest.mark.parametrize('name', LIMITS)
def test_what_is_no_number_is_told(given, name, value):
    given[name] = value
    assert message() == f'Parameter /bridge/{name} is {value!r}, but must be a finite number.'


def test_the_dock_is_a_vertex_of_the_graph(given):
    given['dock_vertex'] = DOCK
    assert read_settings(GRAPH).dock_vertex == DOCK
    assert read_settings(None).dock_vertex == DOCK, 'the graph may come later'
    given['dock_vertex'] = 48
    assert message() == ('~dock_vertex is 48, which is no vertex of the graph: set it to the id of '
                         'the dock, or to 0 if there is none.')
    given['dock_vertex'] = 0
    assert read_settings(GRAPH).dock_vertex is None


@pytest.mark.parametrize('value', ['47', 47.0, True])
def test_a_dock_that_is_no_whole_number_is_told(given, value):
    given['dock_vertex'] = value
    assert message() == f'Parameter /bridge/dock_vertex is {value!r}, but must be of type int.'


@pytest.mark.parametrize('name', STRATEGIES)
def test_a_strategy_has_a_name(given, name):
    given.update(strategy=name, native_command='patrolOnce {goals}')
    assert read_settings(GRAPH).strategy is STRATEGIES[name]


def test_a_strategy_that_there_is_not_is_told_with_those_that_there_are(given):
    given['strategy'] = 'fast'
    assert message() == ("Parameter /bridge/strategy is 'fast', but must be one of "
                         'vertex_by_vertex, direct, rolling, native.')


def test_the_command_of_strategy_native_is_of_no_other(given):
    given['native_command'] = 'patrolOnce {goals}'
    assert read_settings(GRAPH).native_command == ''
    given['strategy'] = 'native'
    assert read_settings(GRAPH).native_command == 'patrolOnce {goals}'
    given['native_command'] = 'executeMacro to_{last}'
    assert read_settings(GRAPH).native_command == 'executeMacro to_{last}'


@pytest.mark.parametrize('template', [
    '', 'goto 12', 'goto {goal}', 'goto {}', 'goto {goals', 'goto {goals:d}', 'goto {goals.first}',
    'goto {goals[first]}', 'goto {goals[0]}'])
def test_a_command_of_strategy_native_without_the_goals_is_told(given, template):
    given.update(strategy='native', native_command=template)
    assert message() == (
        f'~native_command is {template!r}, but strategy native needs the command that takes '
        'several goals, with {goals} for their names or {last} for the last one.')


def test_a_command_of_another_strategy_is_not_looked_at(given):
    given.update(strategy='direct', native_command='goto {')
    assert read_settings(GRAPH).native_command == ''
