"""One table lists all variables that decide where a robot may be (docs/explanation/fleet.md)."""
from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import Dict, Set

import pytest
from fleet_builders import AGV, corridor

from fleet_core.interlocking.route_master import RouteMaster
from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.settings import RobotSettings
from route_protocol.master import MasterState

PAGE = Path(__file__).resolve().parents[4] / 'docs/explanation/fleet.md'
AT_MOST = 25

OTHERS: Dict[str, Set[str]] = {
    'MasterState': set(),
    # not listed: constants; the state of the protocol; data that only plans read
    'RouteRecord': {'graph', 'kind', 'slack', 'protocol', 'generation', 'driven'},
    # not listed: constants; the label of a route; the refused shorter route; a gate; a sign of an
    # outage; values that follow from all others; the function called after a change
    'RouteMaster': {'record', 'clock', 'label', 'cut_refused', 'clock_is_off', 'off_graph',
                    'allocation', 'elsewhere', 'progress', 'tell'},
    # not listed: missions, charging, outages, learned times, and times for new attempts
    'ManagedRobot': {'name', 'type', 'settings', 'master', 'outage', 'why', 'battery', 'liveness',
                     'is_halted', 'comes_to_rest', 'dock', 'passed', 'driven', 'timer', 'refusals',
                     'has_refused', 'unready', 'retried', 'charge_until', 'tops_up'}}


def listed() -> Dict[str, Set[str]]:
    """The variables that the table of the page lists for each class."""
    rows = re.findall(r'^\| (\w+) \| (`[^|]+`) \|', PAGE.read_text(), re.MULTILINE)
    found: Dict[str, Set[str]] = {}
    for owner, names in rows:
        if owner in OTHERS:
            found.setdefault(owner, set()).update(re.findall(r'`(\w+)`', names))
    return found


def variables() -> Dict[str, Set[str]]:
    """The attributes of each class whose objects belong to a robot, without leading underscores.
    """
    master = RouteMaster(RouteRecord(corridor(3), AGV), lambda: 1)
    robot = ManagedRobot('a', AGV, RobotSettings(), master)
    names = {'MasterState': [field.name for field in dataclasses.fields(MasterState)],
             'RouteRecord': vars(master.record), 'RouteMaster': vars(master),
             'ManagedRobot': vars(robot)}
    return {owner: {name.lstrip('_') for name in own} for owner, own in names.items()}


@pytest.mark.parametrize('owner', OTHERS)
def test_the_page_lists_each_variable_that_decides_where_a_robot_may_be(owner: str) -> None:
    assert listed()[owner] == variables()[owner] - OTHERS[owner]
    assert OTHERS[owner] <= variables()[owner], 'a name that is not there any more'


def test_they_are_few() -> None:
    assert sum(map(len, listed().values())) <= AT_MOST
