"""The witness puts another client's command in the order in which the robot took it."""
from __future__ import annotations

import pytest
from delayed_drive import PERSON
from modelled_controller import Delays
from motion_witness import Witness
from test_motion_property import Robots, SimulatedRobots

from omron_arcl import drives
from omron_arcl.drives import Drives
from omron_arcl.execution import NO_GIVER
from omron_ld90.bridge import events as p


def _world(to_robot: float = 0.2) -> Witness:
    return Witness('rolling', Delays(to_robot=to_robot), 'name')


def _stop(world: Witness) -> None:
    world._controller.give('stop', PERSON, 0, lambda result: None)


def _givers(world: Witness) -> list:
    """Returns the giver of each command, in order; None: another client."""
    return [word.giver for word in world.words]


def test_a_foreign_drive_that_the_robot_took_before_our_stop_stands_before_it():
    world = _world()
    world.stall(3.0)
    world.another_client('goto 3')
    _stop(world)
    world.run(4.0)
    assert _givers(world) == [None, PERSON]


def test_a_foreign_drive_that_the_robot_took_after_our_stop_stands_after_it():
    world = _world()
    _stop(world)
    world.run(0.2)
    world.stall(3.0)  # our stop has reached the robot, and its answer is held back
    world.another_client('goto 3')
    world.run(4.0)
    assert _givers(world) == [PERSON, None]


def test_of_two_stops_the_foreign_drive_stands_between_the_one_obeyed_and_the_other():
    world = _world()
    _stop(world)
    world.run(0.2)
    world.stall(3.0)
    world.another_client('goto 3')
    _stop(world)
    world.run(4.0)
    assert _givers(world) == [PERSON, None, PERSON]


def test_a_foreign_drive_stands_last_if_our_stop_was_lost_with_the_link():
    world = _world()
    world.another_client('goto 3')
    _stop(world)
    world.run(0.1)  # the foreign drive is heard, but the stop has not reached the robot yet
    assert _givers(world) == [None, PERSON]
    world.cut(p.RobotLink.COMMANDS, 1.0)
    assert _givers(world) == [PERSON, None]


@pytest.mark.parametrize(('goal', 'heard'), [('3', [None, PERSON, PERSON]),
                                             ('5', [PERSON, PERSON, None])])
def test_a_foreign_drive_does_not_stand_last_if_the_robot_drives_to_a_goal_of_ours_after_it(
        goal, heard):
    """A further foreign drive to the goal of our lost drive looks the same as our drive."""
    robots = Robots()
    robots.begin('rolling', 'name', 0.0, Delays())
    robots.another_client_is_heard_in_parts('goto 4', 3.0)
    robots.person_stops()
    robots.person_drives('3')
    assert _givers(robots.world) == [None, PERSON, PERSON]
    robots.another_client(f'goto {goal}')
    robots.world.cut(p.RobotLink.COMMANDS, 1.0)
    assert _givers(robots.world) == heard


@pytest.mark.parametrize('is_lost', [True, False])
def test_a_giver_drives_on_after_a_drive_of_another_one_that_was_lost_with_the_link(is_lost):
    robots = Robots()
    robots.begin('rolling', 'name', 0.0, Delays(to_robot=0.2))
    robots.person_drives('3')
    robots.passes(1.0)
    robots.reads('/adapter')
    robots.program_drives('/adapter', '4', 0.0)
    robots.passes(0.0 if is_lost else 1.0)
    robots.world.cut(p.RobotLink.COMMANDS, 1.0)
    robots.passes(1.3)
    robots.reads('/adapter')
    robots.person_drives('5')
    robots.passes(1.0)
    adapter = robots.world.words[1]
    assert adapter.is_refused is is_lost
    assert _givers(robots.world) == [PERSON, adapter.giver, *([] if is_lost else [PERSON])]


def test_a_stop_lost_before_the_foreign_drive_is_heard_is_obeyed_once_it_is_sent_again():
    world = _world()
    world.stall(3.0)
    world.another_client('goto 3')
    _stop(world)
    world.cut(p.RobotLink.COMMANDS, 1.0)
    world.run(1.5)
    _stop(world)
    world.run(4.0)
    assert _givers(world) == [None, PERSON, PERSON]
    assert world.robot.goal is None


def test_what_another_client_does_in_an_outage_is_heard_by_the_first_status_after_it():
    robots = Robots()
    robots.begin('rolling', 'name', 0.0, Delays())
    robots.person_drives('3')
    robots.controller_restarts(0.0)
    robots.passes(0.3)
    robots.another_client_is_heard_in_parts('stop', 3.0)
    robots.passes(1.0)
    assert _givers(robots.world) == [PERSON]
    robots.passes(3.0)
    assert _givers(robots.world) == [PERSON, None]


@pytest.mark.parametrize(('goals', 'heard'), [(['4', '3'], []), (['4'], [None]),
                                              (['4', '5'], [None])])
def test_of_what_another_client_does_in_an_outage_only_what_the_robot_shows_after_it_is_heard(
        goals, heard):
    """If the robot drives to a goal of ours again, it does not show the drive in between."""
    robots = Robots()
    robots.begin('rolling', 'status', 0.3, Delays())
    robots.person_drives('3')
    robots.passes(1.0)
    robots.world.stall(3.0)  # the lines are still under way when the link comes back
    robots.world.cut(p.RobotLink.COMMANDS, 1.0)
    for goal in goals:
        robots.another_client(f'goto {goal}')
    robots.passes(4.0)
    assert _givers(robots.world) == [PERSON, *heard]


def _robots_with_an_unheard_stop_of_the_bridge() -> Robots:
    """Returns robots with a person's drive, a failed route, and a stop that no controller hears."""
    robots = Robots()
    robots.begin('rolling', 'name', 0.0, Delays(ends=0.05))
    robots.person_drives('3')
    robots.passes(1.0)
    robots.person_stops()
    robots.passes(4.0)
    robots.person_drives('6')
    robots.controller_restarts(4.0)
    robots.order(0, 1, False)
    robots.passes(4.0)
    assert robots.world.robot.goal == '6' and robots.world._demanded
    return robots


def test_a_stop_of_the_bridge_does_not_end_a_later_drive_even_of_a_person_who_drove_before():
    robots = _robots_with_an_unheard_stop_of_the_bridge()
    robots.person_drives('4')
    robots.passes(20.0)
    assert robots.world.robot.status == 'Arrived at 4'
    assert not robots.world.broken


def test_without_a_later_drive_it_is_found_that_the_stop_of_the_bridge_is_ignored(monkeypatch):
    robots = _robots_with_an_unheard_stop_of_the_bridge()
    monkeypatch.setattr(robots.world, '_take_from_bridge', lambda *_: None)
    robots.passes(20.0)
    assert any('drives on after a stop of the bridge' in words for words in robots.world.broken)


def test_an_emergency_stop_that_was_over_before_the_link_came_back_is_not_heard():
    world = Witness('rolling', Delays(), dialect='interrupted name')
    world.cut(p.RobotLink.COMMANDS, 2.0)
    world.robot.inject('estop press')
    world.robot.inject('estop release')
    world.robot.hear_another('enableMotors')
    world.run(5.0)
    assert _givers(world) == []


@pytest.mark.parametrize('is_planted', [False, True])
def test_it_is_found_that_a_program_drives_a_robot_which_others_stopped_in_an_outage(
        monkeypatch, is_planted):
    if is_planted:
        monkeypatch.setattr(Drives, '_first_shown', lambda self, *_: setattr(
            self, '_unseen', False))
    robots = Robots()
    robots.begin('rolling', 'name', 0.0, Delays())
    robots.program_drives('/adapter', '3', 0.0)
    robots.passes(1.0)
    robots.reads('/adapter')
    robots.world.cut(p.RobotLink.COMMANDS, 1.0)
    robots.another_client('stop')
    robots.passes(4.0)
    robots.program_drives('/adapter', '4', 0.0)
    robots.passes(1.0)
    assert bool(robots.world.broken) is is_planted


@pytest.mark.parametrize('is_planted', [False, True])
def test_it_is_found_that_a_drive_of_others_without_a_name_is_told_as_ours(monkeypatch, is_planted):
    if is_planted:
        monkeypatch.setattr(drives, '_may_cause', lambda drive, activity: drive.may_move)
    robots = SimulatedRobots()
    robots.begin('rolling', 'interrupted name', Delays())
    robots.program_drives('/adapter', '3', 0.0)
    robots.passes(1.0)
    robots.world.cut(p.RobotLink.COMMANDS, 1.0)
    robots.another_client_drives_without_a_goal('gotoPoint 9000 3000 0')
    robots.passes(10.0)
    assert bool(robots.world.broken) is is_planted


@pytest.mark.parametrize('is_planted', [False, True])
def test_it_is_found_that_a_stop_is_told_as_not_obeyed_although_the_robot_stands(
        monkeypatch, is_planted):
    if is_planted:
        monkeypatch.setattr(Drives, '_told_by', lambda self, *stops: ())
    robots = Robots()
    robots.begin('rolling', 'name', 0.0, Delays())
    robots.order(0, 1, True)
    robots.passes(1.0)
    robots.world.cut(p.RobotLink.COMMANDS, 5.0)
    robots.stop_order()
    robots.passes(0.3)
    robots.person_stops()
    robots.passes(15.0)
    assert robots.world.robot.goal is None
    assert bool(robots.world.broken) is is_planted


def test_a_stop_of_the_bridge_does_not_end_a_drive_that_the_robot_had_not_answered_in_its_epoch():
    """The bridge learns that the robot obeys the bridge's drive after all, and gives a stop. Later
    the bridge learns that a person has given a drive before the stop.
    """
    robots = SimulatedRobots()
    robots.begin('rolling', 'interrupted name', Delays(commands=1.0, motions=1.0, to_robot=0.2))
    robots.order(0, 2, True)
    robots.passes(1.0)
    robots.another_client_is_heard_in_parts('goto 4', 3.0)
    robots.person_drives('6')
    robots.passes(30.0)
    assert robots.world.robot.status == 'Arrived at 6'
    assert not robots.world.broken


def _world_in_which_another_client_drives_a_robot_that_docks_for_us() -> Witness:
    world = Witness('rolling', Delays(), dialect='interrupted name')
    world._controller.give('dock', PERSON, 0, lambda result: None)
    world.run(1.0)
    world.another_client('goto 3')
    return world


def test_a_robot_that_was_to_dock_seems_to_dock_if_nobody_heard_of_the_other_clients_drive():
    world = _world_in_which_another_client_drives_a_robot_that_docks_for_us()
    world.restart_controller()  # so the line `Going to 3` is lost
    world.run(10.0)
    memory = world._controller.motion.memory
    assert (memory.names, memory.giver, world.robot.goal) == (('dock',), PERSON, '3')
    assert not world.broken


def test_a_robot_that_was_to_dock_drives_for_the_other_client_if_the_drive_was_heard():
    world = _world_in_which_another_client_drives_a_robot_that_docks_for_us()
    world.run(10.0)
    assert world._controller.motion.memory.giver == NO_GIVER
    assert not world.broken


@pytest.mark.parametrize('is_planted', [False, True])
def test_it_is_found_that_a_drive_of_others_is_told_as_our_way_into_the_dock(
        monkeypatch, is_planted):
    if is_planted:
        monkeypatch.setattr(Drives, 'lost_drives', lambda self, activity: [])
    world = Witness('rolling', Delays(), dialect='interrupted name')
    world._controller.give('dock', PERSON, 0, lambda result: None)
    world.run(1.0)
    world.cut(p.RobotLink.COMMANDS, 1.0)
    world.run(2.0)  # a status has shown that the robot still docks
    world.another_client('goto 3')
    world.run(10.0)
    assert bool(world.broken) is is_planted


def test_an_owed_stop_waits_for_the_answer_to_a_later_drive_while_the_robot_stands():
    """The robot docks during an outage, in which a stop is given. Then a person sends it on, and
    another client stops it before it has named the goal of this drive.
    """
    robots = SimulatedRobots()
    robots.begin('rolling', 'interrupted name', Delays())
    robots.robot_leaves_its_dock_for_a_cancelled_drive(0.3)
    robots.order_comes_before_the_robot_has_said_why_it_broke_off(0, 'goto 4')
    robots.epoch_of_others_is_replaced_by_one_of_the_bridge(('person_stops',))
    robots.route_fails_without_a_controller(p.RobotLink.COMMANDS)
    robots.person_drives_as_a_route_fails('3', p.RobotLink.COMMANDS)
    robots.another_client('stop')
    robots.world.run(10.0)
    assert robots.world._controller.motion.memory.stop_owed
    robots.world.run(60.0)  # until the drive has timed out
    assert not robots.world._controller.motion.memory.stop_owed
    assert robots.world.robot.goal is None
    assert not robots.world.broken


def test_a_robot_that_refuses_a_drive_of_ours_goes_on_for_the_other_client():
    robots = SimulatedRobots()
    robots.begin('rolling', 'missing dock undock', Delays())
    robots.passes(1.0)
    robots.another_client_is_heard_in_parts('goto 4', 0.5)
    robots.stop_of_a_person_is_lost(1.0)
    robots.take(PERSON, 'dock', 0)
    robots.passes(20.0)
    assert robots.world.robot.status == 'Arrived at 4'
    assert not robots.world.broken


@pytest.mark.parametrize(('commands', 'drives'), [
    (['goto 99', 'goto 3'], True), (['goto 3', 'goto 99'], True), (['goto 99', 'goto 98'], False)])
def test_of_two_drives_of_one_giver_the_robot_may_refuse_one(commands, drives):
    world = Witness('rolling', Delays(to_robot=0.2), dialect='missing dock undock')
    for command in commands:
        world._controller.give(command, PERSON, 0, lambda result: None)
    world.run(4.0)
    assert [word.drives for word in world.words] == [drives]


def test_another_clients_stop_that_crosses_a_drive_of_ours_is_not_heard_also_after_a_stall():
    """The robot's words are those of a robot that stops for an instant to replace a drive."""
    robots = SimulatedRobots()
    robots.begin('rolling', 'interrupted name', Delays(to_robot=0.2))
    robots.program_drives('/joystick', '3', 1.0)  # arrives when the other client stops the robot
    for program in ('/joystick', '/adapter'):
        robots.program_drives_before_the_robot_has_said_why_it_broke_off(program, '3', 'stop')
    assert not robots.world.broken


def test_a_drive_of_ours_that_is_on_its_way_stands_behind_each_foreign_drive_before_it():
    world = _world()
    for _ in range(2):
        world.another_client('goto 3')
    world._controller.give('goto 6', PERSON, 0, lambda result: None)
    world.run(4.0)
    assert _givers(world)[-1] == PERSON
    assert world.robot.status in ('Going to 6', 'Arrived at 6')
