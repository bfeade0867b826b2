"""The fleet in the text format of Prometheus."""
from __future__ import annotations

from collections import Counter
from typing import Iterable, Tuple

from fleet_page.core.fleet import DEADLINE_STATES, MISSION_STATES, OPEN_STATES, ROBOT_STATES
from fleet_page.core.fleet_model import FleetModel
from fleet_page.core.latencies import Histogram

CONTENT_TYPE = 'text/plain; version=0.0.4'


def metrics_text(model: FleetModel, planner: Histogram, release: Histogram,
                 clients: int) -> str:
    """Returns all metrics at present."""
    fleet = model.live.get('fleet') or {}
    lines = (
        *_family('fleet_manager_up', 'gauge', '1 while the fleet manager publishes its state.',
                 [f'fleet_manager_up {int(bool(fleet.get("alive")))}']),
        *_family('fleet_stopped', 'gauge', '1 while the fleet is stopped.',
                 [f'fleet_stopped {int(model.live.get("stop") is not None)}']),
        *_of_missions(model), *_of_robots(model),
        *_family('fleet_planner_seconds', 'histogram', 'Time that the planner took for an answer.',
                 planner.lines('fleet_planner_seconds')),
        *_family('fleet_release_seconds', 'histogram', 'Time that robots with a plan waited for '
                 'their next edge.', release.lines('fleet_release_seconds')),
        *_family('fleet_page_clients', 'gauge', 'Browsers that follow the fleet.',
                 [f'fleet_page_clients {clients}']))
    return '\n'.join(lines) + '\n'


def _of_missions(model: FleetModel) -> Iterable[str]:
    are_open = [status for status in model.missions.values() if status.state in OPEN_STATES]
    states = Counter(status.state for status in are_open)
    deadlines = Counter(status.deadline for status in are_open)
    yield from _by('state', 'fleet_missions', 'gauge', 'Open missions by state.',
                   ((state, states[state]) for state in OPEN_STATES))
    yield from _by('state', 'fleet_mission_deadlines', 'gauge',
                   'Open missions with a deadline, by what is expected of it.',
                   ((state, deadlines[state]) for state in DEADLINE_STATES if state != 'NONE'))
    yield from _by('state', 'fleet_missions_ended_total', 'counter',
                   'Missions that ended while the page ran.',
                   ((state, model.ended.get(state, 0)) for state in MISSION_STATES
                    if state not in OPEN_STATES))


def _of_robots(model: FleetModel) -> Iterable[str]:
    robots = model.robots.values()
    states = Counter(robot.state for robot in robots)
    yield from _by('state', 'fleet_robots', 'gauge', 'Robots by state.',
                   ((state, states[state]) for state in ROBOT_STATES))
    yield from _by('robot', 'fleet_robot_waiting', 'gauge', '1 while a robot with a mission waits.',
                   ((robot.name, int(robot.is_waiting))
                    for robot in robots))
    yield from _by('robot', 'fleet_robot_battery_ratio', 'gauge', 'State of charge, 0 to 1.',
                   ((robot.name, f'{robot.battery:g}') for robot in robots
                    if robot.battery is not None))
    yield from _by('robot', 'fleet_robot_distance_metres_total', 'counter',
                   'Distance while the page ran.',
                   ((name, f'{distance:.2f}') for name, distance in sorted(model.distance.items())))


def _by(label: str, name: str, kind: str, words: str,
        values: Iterable[Tuple[str, object]]) -> Iterable[str]:
    """Returns one metric, with a sample for each value of a label."""
    return _family(name, kind, words, (
        f'{name}{{{label}="{escaped(own)}"}} {value}' for own, value in values))


def _family(name: str, kind: str, words: str, samples: Iterable[str]) -> Iterable[str]:
    return (f'# HELP {name} {words}', f'# TYPE {name} {kind}', *samples)


def escaped(text: str) -> str:
    """Returns the text, escaped as the value of a label."""
    return text.replace('\\', '\\\\').replace('"', '\\"').replace('\n', '\\n')
