"""The adapter is killed and restarts: the order is still there, and nothing is done twice."""
from __future__ import annotations

import json

import pytest
from vda_builders import IDENTITY, STANDING, Lab, RobotSide, abilities, say, table, way
from vda_builders import lab as laboratory

from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core import journal
from vda5050_vehicle.core.journal import WrongRecord
from vda5050_vehicle.drivers.order_graph import Matching
from vda5050_vehicle.drivers.pose_driver import PoseDrive
from vda5050_vehicle.drivers.route_driver import PATIENCE, RouteDrive, RouteDriver
from vda5050_vehicle.nodes import files
from vda5050_vehicle.nodes.files import JournalLog

HALL = way(8, 10, 12, 14, 32)


def test_the_order_goes_on_where_the_robot_drives_its_route():
    lab = Lab()
    lab.order(HALL.order('o', base=4, actions={'14': [say('later', 'HARD')]}))
    lab.drive(1)
    routes = list(lab.robot.routes)
    lab = lab.restarted()
    assert lab.nodes == ['12', '14', '32']
    assert lab.robot.routes == routes, 'nothing may be sent before the robot has reported'
    lab.drive(2)
    assert lab.status('later') == 'RUNNING'
    lab.end_action('later')
    lab.order(HALL.part(3).order('o', 1, first_sequence=6))
    lab.drive(1)
    assert lab.nodes == []
    assert lab.errors == []


@pytest.mark.parametrize('base', [None, 3])
def test_a_base_that_was_driven_to_its_end_needs_nobody_after_a_restart_of_everything(base):
    lab = Lab()
    lab.order(HALL.order('o', base=base))
    lab.drive(2 if base else 4)
    lab = lab.restarted()
    lab.robot.__init__()
    lab.wait(PATIENCE + 1.0)
    assert (lab.errors, lab.state['paused']) == ([], False)
    end = HALL.stops[2] if base else HALL.stops[4]
    lab.order(way(int(end.node_id), 14 if base else 12).order('o', 1, first_sequence=(
        4 if base else 8)))
    lab.wait(0.2)
    assert lab.robot.drives


def test_nodes_that_were_passed_meanwhile_are_passed_and_their_actions_not_made_up_for():
    lab = Lab()
    lab.order(HALL.order('o', actions={'12': [say('missed')], '14': [say('there')]}))
    lab.robot.done = 3
    lab = lab.restarted()
    lab.wait(0.1)
    assert lab.nodes == ['32']
    assert (lab.status('missed'), lab.status('there')) == ('FAILED', 'RUNNING')


def test_started_actions_have_failed_and_are_never_run_again():
    lab = Lab()
    lab.order(HALL.order('o', actions={'8': [say('a', 'HARD')], '10': [say('b', 'HARD')]}))
    lab.act('say', 'instant', text='hello')
    lab = lab.restarted()
    lab.wait(1.0)
    assert (lab.status('a'), lab.status('b'), lab.status('instant')) == (
        'FAILED', 'WAITING', 'FAILED')
    assert lab.started == []
    assert not lab.robot.routes, 'the vehicle had to stand for the action, so a master must decide'
    assert lab.errors == ['actionError']
    lab.act('stopPause')
    assert lab.robot.route == (1,)


def test_an_extension_that_was_not_sent_any_more_is_sent():
    lab = Lab()
    lab.order(HALL.order('o', base=2))
    lab.robot.answers = False  # killed between the journal and the robot
    sent = lab.robot.routes.copy()
    lab.order(HALL.part(1).order('o', 1, first_sequence=2))
    lab.robot.routes = sent
    lab.robot.answers = True
    lab = lab.restarted()
    lab.wait(1.5)
    assert lab.robot.route == (1, 2, 3, 4)
    assert lab.errors == []


def test_a_robot_that_forgot_the_route_is_not_sent_on_by_itself():
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.drive(1)
    routes = list(lab.robot.routes)
    lab.robot.vehicle = RobotSide().vehicle
    lab = lab.restarted()
    lab.wait(30.0)
    assert lab.robot.routes == routes
    assert lab.errors == ['driveError']
    assert lab.nodes == ['12', '14', '32']
    lab.act('stopPause')
    lab.wait(0.2)
    assert lab.robot.route == (2, 3, 4)


def test_a_robot_that_stays_silent_is_given_up():
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.robot.answers = False
    lab = lab.restarted()
    lab.wait(PATIENCE + 1.0)
    assert lab.errors == ['driveError']


@pytest.mark.parametrize('begins', [False, True])
def test_an_order_of_a_journal_that_may_be_an_older_one_is_held(begins):
    """The order may have been cancelled after the older journal was written."""
    lab = Lab()
    if not begins:
        lab.robot.answers = False
    lab.order(HALL.order('o'))
    lab = lab.restarted(is_newest=False)
    lab.robot.answers = True
    lab.wait(0.3)
    assert lab.errors == ['driveError']
    assert not lab.robot.drives
    lab.act('stopPause')
    lab.wait(1.5)
    assert lab.robot.route == (1, 2, 3, 4)


def test_a_journal_of_an_earlier_boot_is_known_as_such(tmp_path, monkeypatch):
    path, lab = tmp_path / 'journal', Lab()
    lab.order(HALL.order('o'))
    monkeypatch.setattr(files, 'boot_id', lambda: 'earlier')
    JournalLog(path).write(None, lab.vehicle.state)
    assert JournalLog(path).read(RouteDrive) == (lab.vehicle.state, True)
    monkeypatch.undo()
    assert JournalLog(path).read(RouteDrive) == (lab.vehicle.state, False)


def test_an_order_that_no_journal_has_is_stopped():
    lab = Lab()
    lab.order(HALL.order('o'))
    assert lab.robot.drives
    new = Lab()
    new.robot = lab.robot
    new.vehicle = type(new.vehicle)(IDENTITY, new.codec, table(), new.make_driver, abilities())
    new.driver = new.vehicle.driver
    new.wait(0.2)
    assert not new.robot.drives
    new.order(way(8, 10).order('p'))
    new.wait(0.2)
    assert (new.errors, new.robot.route) == ([], (1,))


@pytest.mark.parametrize('kind', ['cancelOrder', 'startPause'])
def test_a_stop_wins_though_the_clock_was_set_back_and_the_journal_was_lost(kind):
    lab = Lab()
    lab.order(HALL.order('o'))
    new = Lab()
    new.robot = lab.robot
    new.vehicle = type(new.vehicle)(IDENTITY, new.codec, table(), lambda memory: RouteDriver(
        memory, laboratory(), abilities(), Matching(), lambda: 5), abilities())
    new.driver = new.vehicle.driver
    new.act(kind)
    new.wait(0.3)
    assert not new.robot.drives


def test_another_order_right_after_a_restart_is_driven():
    lab = Lab()
    lab.order(way(8, 10).order('o'))
    lab.drive(1)
    lab.robot.answers = False
    lab = lab.restarted()
    lab.order(way(10, 12).order('p'))
    lab.robot.answers = True
    lab.wait(1.5)
    assert lab.robot.route == (2,)
    lab.drive(1)
    assert lab.state['lastNodeId'] == '12'


def test_a_failure_is_not_forgotten():
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.robot.fail('emergency stop')
    lab.wait(0.1)
    lab = lab.restarted()
    lab.wait(5.0)
    assert lab.errors == ['driveError']
    assert lab.state['errors'][0]['errorDescription'] == 'emergency stop'
    assert not lab.state['paused'], 'there was no pause'


def test_a_stop_that_was_owed_is_given():
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.robot.answers = False
    lab.act('startPause')
    lab.robot.routes.clear()
    lab = lab.restarted()
    lab.wait(0.1)
    assert [command.edges for command in lab.robot.routes] == [()]
    lab.robot.answers = True
    lab.wait(5.0)
    lab.see(velocity=STANDING)
    assert lab.state['paused']
    assert lab.nodes == ['10', '12', '14', '32']


def test_a_cancelled_order_stays_cancelled():
    lab = Lab()
    lab.order(HALL.order('o'))
    lab.act('cancelOrder')
    lab.settle()
    lab = lab.restarted()
    lab.order(HALL.order('o', 1))
    assert lab.errors == ['orderUpdateError']


def whole(lab):
    """Returns the state of a vehicle, as one record of the journal."""
    return json.loads(journal.line(None, lab.vehicle.state))


def test_a_log_of_changes_is_the_state():
    lab = Lab()
    lab.order(HALL.order('o', base=3, actions={'10': [say('a', 'HARD')], '2': [say('b')]}))
    lab.drive(1)
    lab.end_action('a', False, 'no voice')
    lab.act('stopPause')
    lab.order(way(12, 14).order('o', 1, first_sequence=4))
    lab.drive(2)
    lab.act('fly')
    lab.act('cancelOrder')
    assert len(lab.journal) > 10
    assert journal.read(lab.journal, RouteDrive) == lab.vehicle.state


@pytest.mark.parametrize('damage', [
    lambda record: record['='].pop('order'), lambda record: record.update(version=0),
    lambda record: record['=']['order'].update(nodes=5),
    lambda record: record['='].update(drive={}),
    lambda record: record['=']['order']['nodes'][0].pop('node_id'),
    lambda record: record['=']['legs'][0].update(colour='red')])
def test_a_journal_that_makes_no_sense_is_refused(damage):
    lab = Lab()
    lab.order(HALL.order('o'))
    record = whole(lab)
    damage(record)
    with pytest.raises(WrongRecord):
        journal.read([json.dumps(record)], RouteDrive)


def test_a_journal_of_another_driver_is_refused():
    lab = Lab()
    with pytest.raises(WrongRecord):
        journal.read(lab.journal, PoseDrive)


def test_a_journal_file_is_a_log_and_an_unfinished_line_is_of_nothing_that_was_done(tmp_path):
    path = tmp_path / 'journal'
    file, lab = JournalLog(path), Lab()
    lab.order(HALL.order('o'))
    for effect in lab.effects:
        if isinstance(effect, fx.Keep):
            file.write(effect.before, effect.now)
            known = effect.now
    assert len(path.read_text().splitlines()) > 1
    with open(path, 'a') as log:
        log.write('{"~": {"pau')
    assert JournalLog(path).read(RouteDrive) == (known, True)
    file = JournalLog(path)
    file.write(known, known)
    assert len(path.read_text().splitlines()) == 1, 'each run must begin it anew'
