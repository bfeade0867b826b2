"""The command `fleet list` says how every robot stands."""
from __future__ import annotations

import pytest

from graph_fleet_manager.commands import fleet
from graph_fleet_manager.supervision.fleet_view import RobotState
from itrci_nav_msgs.msg import FleetRobot, FleetState


@pytest.mark.parametrize('state', RobotState)
def test_every_state_has_its_word(state):
    robot = FleetRobot(name='a', type='agv', state=int(state),
                       outage_code=FleetRobot.OUTAGE_SILENT)
    line = fleet._listed(FleetState(robots=[robot])).splitlines()[1]
    assert line.split('agv')[1].strip().startswith(state.name.lower().replace('_', ' '))
