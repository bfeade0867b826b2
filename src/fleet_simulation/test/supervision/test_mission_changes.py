"""MODIFY: another priority, and other destinations from now on."""
from __future__ import annotations

import pytest
from fleet_builders import AGV, corridor

from fleet_core.supervision.actions import Note, TellStatus
from fleet_core.supervision.missions import (
    Change,
    Command,
    CommandCode,
    MissionState,
    Request,
)
from world.supervised_fleet import SupervisedFleet


def modify(fleet, mission, priority=0, *destinations):
    actions = fleet.supervisor.command(mission, Command.MODIFY, fleet.now,
                                       Change(priority, destinations))
    fleet.do(actions)
    return [action.status for action in actions if isinstance(action, TellStatus)]


def test_a_robot_under_way_goes_to_the_new_destinations():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 3, 8)
    fleet.run_until(lambda: fleet.reached(1) == 1)
    modify(fleet, 1, 0, 2, 5)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.reached(1) == 3
    assert fleet.agvs['a'].visited[-1] == 5 and 8 not in fleet.agvs['a'].visited
    assert 2 in fleet.agvs['a'].visited[1:]


def test_a_stay_under_way_ends_with_the_change():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 3, 6, dwells=(-1.0, -1.0))
    fleet.run_until(lambda: fleet.agvs['a'].visited[-1] == 3 and not fleet.agvs['a'].is_driving)
    fleet.run(5.0)
    modify(fleet, 1, 0, 5)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.agvs['a'].visited[-1] == 5


def test_a_mission_that_waits_overtakes_by_its_new_priority():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    for mission, vertex in ((1, 3), (2, 4), (3, 5)):
        fleet.request(mission, vertex)
    fleet.run(1.0)
    modify(fleet, 3, 5)
    fleet.run_until_done(1, 3)
    assert fleet.state(2) is not MissionState.SUCCEEDED
    fleet.run_until_done(2)


@pytest.mark.parametrize('vertex', [99, -1])
def test_a_change_that_no_robot_can_do_changes_nothing(vertex):
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 4)
    fleet.run(1.0)
    told, = modify(fleet, 1, 0, vertex)
    assert told.command_code is CommandCode.NOT_DONE and f'no vertex {vertex}' in told.reason
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.agvs['a'].visited[-1] == 4


def test_a_change_outlives_a_restart():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run(2.0)
    modify(fleet, 1, 3, 5)
    fleet.restart()
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.agvs['a'].visited[-1] == 5


def test_who_requested_a_mission_and_its_end_is_told_and_kept():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    notes = [action.text for action in fleet.supervisor.request(
        Request(1, (6,), requested_by='anna (page)'), fleet.now) if isinstance(action, Note)]
    assert notes == ['anna (page) requests mission 1 to 6.']
    actions = fleet.supervisor.command(1, Command.CANCEL, fleet.now, requested_by='boris (page)')
    fleet.do(actions)
    assert any(isinstance(action, Note) and action.text == 'boris (page) requests CANCEL of '
               'mission 1.' for action in actions)
    told, = (action.status for action in actions if isinstance(action, TellStatus))
    assert told.reason == 'cancelled on request of boris (page)'
