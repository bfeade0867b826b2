"""Reads the bridge's parameters; `omron_edges_to_vertices` lists them."""
from __future__ import annotations

from typing import Optional

from node_lifecycle import ConfigurationError, choice, number, parameter
from omron_ld90.bridge.route_strategies import STRATEGIES, RouteSettings
from trajectory_graph import Graph


def read_settings(graph: Optional[Graph]) -> RouteSettings:
    """Returns the settings for driving routes; raises ConfigurationError."""
    dock = parameter('~dock_vertex', 0, int)
    if graph is not None and dock and dock not in graph.vertices:
        raise ConfigurationError(
            f'~dock_vertex is {dock}, which is no vertex of the graph: set it to the id of the '
            'dock, or to 0 if there is none.')
    strategy = choice('~strategy', 'rolling', tuple(STRATEGIES))
    native_command = parameter('~native_command', '')
    if strategy == 'native':
        _check_native_command(native_command)
    return RouteSettings(
        dock_vertex=dock or None,
        strategy=STRATEGIES[strategy],
        native_command=native_command if strategy == 'native' else '',
        vertex_tolerance=number('~vertex_tolerance', 0.3, 0.05, 2.0),
        corridor_width=number('~corridor_width', 0.9, 0.3, 10.0),
        stall_timeout=number('~stall_timeout', 30.0, 1.0, 3600.0),
        location_timeout=number('~location_timeout', 5.0, 0.5, 60.0),
        link_timeout=number('~link_timeout', 2.0, 0.0, 60.0),
        restart_timeout=number('~restart_timeout', 20.0, 0.0, 600.0),
        top_speed=number('~top_speed', 1.35, 0.1, 10.0),
        acceleration=number('~acceleration', 0.5, 0.05, 10.0),
        braking=number('~braking', 0.2, 0.05, 10.0))


def _check_native_command(template: str) -> None:
    try:
        wrong = '1 2' not in template.format(goals='1 2', last='1 2')
    except (LookupError, ValueError, AttributeError, TypeError):
        wrong = True
    if wrong:
        raise ConfigurationError(
            f'~native_command is {template!r}, but strategy native needs the command that takes '
            'several goals, with {goals} for their names or {last} for the last one.')
