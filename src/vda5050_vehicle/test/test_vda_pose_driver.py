"""Orders for a robot with move_base and without a graph."""
from __future__ import annotations

import math

import pytest
from vda_builders import DRIVING, STANDING, Lab, abilities, way

from vda5050_vehicle.drivers.order_graph import Matching
from vda5050_vehicle.drivers.pose_driver import CancelGoals, GoTo, PoseDriver
from vda5050_vehicle.drivers.robot_view import RobotPose

HALL = way(8, 10, 12, 14)
PLACES = [(stop.x, stop.y) for stop in HALL.stops]


class MoveBaseLab(Lab):
    """The laboratory's vehicle with poses instead of routes."""

    def __init__(self) -> None:
        super().__init__(driver=lambda memory: PoseDriver(
            memory, abilities(), Matching()))

    def at(self, x, y, velocity=DRIVING):
        self.see(pose=RobotPose(x, y, 0.0), velocity=velocity)

    @property
    def goals(self):
        return [command for command in self.robot.routes if isinstance(command, GoTo)]

    def end_goal(self, succeeded=True, text=''):
        self.driver.on_goal_ended(self.goals[-1].number, succeeded, text, self.now)
        self.see(velocity=STANDING)


@pytest.fixture
def lab(monkeypatch):
    lab = MoveBaseLab()
    monkeypatch.setattr(lab.robot, 'arrive', lab.robot.routes.append)
    lab.at(*PLACES[0], STANDING)
    return lab


def test_nodes_on_the_way_are_passed_without_a_stop(lab):
    lab.order(HALL.order('o'))
    assert [(goal.x, goal.y) for goal in lab.goals] == [PLACES[1]]
    assert lab.goals[0].theta == pytest.approx(0.0)
    lab.at(PLACES[1][0] - 0.3, PLACES[1][1])
    assert lab.state['lastNodeId'] == '10'
    assert (lab.goals[-1].x, lab.goals[-1].y) == PLACES[2]
    lab.driver.on_goal_ended(lab.goals[0].number, False, 'preempted', lab.now)
    lab.wait(0.1)
    assert lab.errors == [], 'our own goal has replaced it'
    lab.at(PLACES[2][0], PLACES[2][1])
    lab.at(PLACES[3][0], PLACES[3][1])
    assert lab.nodes == ['14'], 'the last node must be passed when move_base has arrived'
    lab.end_goal()
    assert lab.nodes == []


def test_a_heading_on_the_way_is_taken(lab):
    order = HALL.order('o')
    order['nodes'][1]['nodePosition']['theta'] = math.pi / 2
    lab.order(order)
    assert lab.goals[0].theta == pytest.approx(math.pi / 2)
    lab.at(*PLACES[1])
    assert lab.state['lastNodeId'] == '8'
    lab.end_goal()
    assert lab.state['lastNodeId'] == '10'
    assert len(lab.goals) == 2


def test_the_heading_of_the_first_node_is_refused_where_the_robot_has_another(lab):
    order = HALL.order('o')
    order['nodes'][0]['nodePosition']['theta'] = 1.0
    lab.order(order)
    assert (lab.errors, lab.goals) == (['orderError'], [])
    order['nodes'][0]['nodePosition']['theta'] = 0.0
    lab.order(order)
    assert lab.errors == []


def test_the_base_grows_and_the_horizon_is_not_driven(lab):
    lab.order(HALL.order('o', base=2))
    lab.at(*PLACES[1])
    lab.end_goal()
    assert len(lab.goals) == 1
    lab.order(HALL.part(1).order('o', 1, first_sequence=2))
    assert (lab.goals[-1].x, lab.goals[-1].y) == PLACES[2]


def test_a_goal_that_fails_holds_the_vehicle_until_stop_pause(lab):
    lab.order(HALL.order('o'))
    lab.end_goal(False, 'no valid plan')
    assert lab.state['errors'][0]['errorDescription'] == 'no valid plan'
    goals = len(lab.goals)
    lab.wait(30.0)
    assert len(lab.goals) == goals
    lab.act('stopPause')
    assert (lab.goals[-1].x, lab.goals[-1].y) == PLACES[1]


def test_pause_and_cancel_cancel_the_goal(lab):
    lab.order(HALL.order('o'))
    pause = lab.act('startPause')
    assert lab.robot.routes[-1] == CancelGoals()
    assert lab.status(pause) == 'RUNNING'
    lab.end_goal(False, 'cancelled')
    assert lab.status(pause) == 'FINISHED'
    lab.act('stopPause')
    assert len(lab.goals) == 2
    cancel = lab.act('cancelOrder')
    lab.end_goal(False, 'cancelled')
    assert lab.status(cancel) == 'FINISHED'


class TestAPersonStopsTheRobot:
    """The robot brakes for a while; until it stands, it may pass or reach a node."""

    def test_it_is_not_driven_on_from_a_node_that_it_passes(self, lab):
        lab.order(HALL.order('o'))
        lab.at(*PLACES[0])
        lab.see(halted=True)
        lab.at(*PLACES[1])
        assert len(lab.goals) == 1
        lab.end_goal(False, 'preempted')
        assert (lab.errors, len(lab.goals)) == (['driveError'], 1)

    def test_nor_from_a_node_that_it_has_just_reached(self, lab):
        lab.order(HALL.order('o'))
        lab.at(*PLACES[0])
        lab.see(halted=True)
        lab.end_goal()
        assert (lab.state['lastNodeId'], lab.errors, len(lab.goals)) == ('10', ['driveError'], 1)

    def test_what_halted_it_before_its_goal_does_not_count(self, lab):
        lab.see(halted=True)
        lab.order(HALL.order('o'))
        lab.at(*PLACES[1])
        assert (lab.errors, len(lab.goals)) == ([], 2)
        lab.see(halted=False)
        lab.end_goal()
        assert (lab.errors, len(lab.goals)) == ([], 3)


def test_a_node_without_a_position_cannot_be_driven_to(lab):
    order = HALL.order('o')
    del order['nodes'][2]['nodePosition']
    lab.order(order)
    assert lab.errors == ['noRouteError']


def test_after_a_restart_the_goal_is_cancelled_and_the_vehicle_held(lab):
    lab.order(HALL.order('o'))
    lab = lab.restarted()
    assert lab.robot.routes[-1] == CancelGoals()
    assert lab.errors == ['driveError']
