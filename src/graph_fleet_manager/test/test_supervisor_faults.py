"""Robots that drop out, stand elsewhere than was thought, or come back: who moves then, and how."""
from __future__ import annotations

from fleet_builders import AGV, corridor
from supervised_fleet import SupervisedFleet

from graph_fleet_manager.supervision.missions import Command, MissionState


def test_a_paused_mission_whose_robot_drops_out_stays_paused():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.step()
    fleet.request(1, 4)
    fleet.run(2.0)
    assert fleet.robot_of(1) == 'a'
    fleet.do(fleet.supervisor.command(1, Command.PAUSE, fleet.now))
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(20.0)
    assert fleet.state(1) is MissionState.PAUSED and fleet.agvs['b'].travelled == 0.0
    fleet.do(fleet.supervisor.command(1, Command.RESUME, fleet.now))
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.robot_of(1) == 'b'


def test_what_is_refused_in_an_emergency_stop_does_not_count_against_the_robot():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run(2.5)
    fleet.agvs['a'].emergency = True
    fleet.run(15.0)
    fleet.agvs['a'].emergency = False
    fleet.agvs['a'].refusing = 1
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED
