"""A bridge that missed epochs learns from `foreign_epoch` alone whether others have acted."""
from __future__ import annotations

import pytest
from bridge_builders import BRIDGE, told_of
from modelled_controller import Delays
from motion_witness import Witness

from omron_arcl import Giver, Outcome, parse_command, parse_line
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.drives import Drives, Overruled
from omron_ld90.bridge.events import CommandEnded, RobotLink
from omron_ld90.bridge.robot_monitor import RobotMonitor
from omron_ld90.bridge.route_strategies import RouteSettings
from route_protocol.values import EpochCause

OURS, PERSON, PROGRAM = Giver(BRIDGE, 'a'), Giver('/rviz', 'b'), Giver('/adapter', 'c')
LOST = ('lose',)


class Told:
    """A bridge and a controller. The bridge hears of an act only if the test calls `tell`."""

    def __init__(self, master: str = '') -> None:
        self.memory = None
        self.number = 0
        self.robot = RobotMonitor(RouteSettings(), master=lambda: master)
        self.start()
        self.tell()

    def start(self):
        self.records = Drives(self.memory, self._keep)
        self.dispatcher = Dispatcher(self.records)
        self.connect()

    def _keep(self, memory):
        self.memory = memory

    def tell(self):
        self.robot.update(told_of(self.records.motion), 0.0)

    def give(self, giver, command):
        self.number += giver is OURS
        self.dispatcher.start(parse_command(command), giver=giver,
                              number=self.number if giver is OURS else 0)
        self.send()

    def send(self):
        while self.dispatcher.next_to_send(0.0) is not None:
            pass

    def say(self, *lines):
        for line in lines:
            self.dispatcher.on_reply(parse_line(line), line, 0.0)
            self.send()

    def shows(self, status):
        self.say(f'Status: {status} StateOfCharge: 80.0 Location: 0 0 0 Temperature: 30')

    def connect(self):
        self.dispatcher.on_connected(0.0)

    def lose(self):
        self.dispatcher.on_lost('the link broke')

    def stop_without_link(self):
        self.number += 1
        self.dispatcher.start_without_link(parse_command('stop'), OURS, 0, self.number)

    def restart_bridge(self):
        before, self.robot = self.robot, RobotMonitor(RouteSettings())
        self.robot.resume(before.epoch, before.foreign_epoch, self.number)

    def cancel(self, giver):
        self.records.all_cancelled(giver)

    def act(self, *acts):
        for name, *arguments in acts:
            getattr(self, name)(*arguments)


WE_DRIVE = ('give', OURS, 'goto 3'), ('say', 'Going to 3')
WE_STOP = ('give', OURS, 'stop'), ('say', 'Stopping', 'Stopped')


@pytest.mark.parametrize('missed', [
    (('give', PERSON, 'stop'), ('say', 'Stopping', 'Stopped')), (('give', PERSON, 'stop'),),
    (('give', PERSON, 'stop'), ('say', 'Stopping', 'Stopped'), ('restart_bridge',)),
    (('give', PERSON, 'stop'), ('start',), ('shows', 'Stopped')),
    (('cancel', PERSON),), (('say', 'Interrupted: Going to 3', 'Stopping', 'Stopped'),),
    (('say', 'EStop pressed', 'EStop relieved', 'Motors enabled'),),
    (('give', PROGRAM, 'goto 4'), ('say', 'Going to 4')),
    (('say', 'Going to 5'), ('shows', 'Going to 5'), ('shows', 'Going to 5')),
    (LOST, ('connect',), ('shows', 'Stopped')), (LOST, ('connect',))])
def test_what_others_did_is_known_also_from_a_later_epoch_of_ours(missed):
    told = Told()
    told.act(*WE_DRIVE)
    told.tell()
    told.act(*missed, *WE_STOP)
    told.tell()
    assert told.robot.overruled is EpochCause.OTHER_GIVER


def test_nobody_drives_on_after_a_stop_that_an_epoch_of_ours_has_replaced():
    told = Told()
    told.act(*WE_STOP)
    told.tell()
    told.act(('give', PERSON, 'stop'), ('say', 'Stopping', 'Stopped'), *WE_DRIVE)
    told.tell()
    told.robot.tracker.send('4', 'goto 4')
    assert told.robot.due_commands(0.0) == []


@pytest.mark.parametrize('missed', [
    (), WE_STOP, (*WE_STOP, *WE_DRIVE), (*WE_STOP, ('restart_bridge',)),
    (('cancel', OURS), *WE_STOP), (('start',),), (*WE_STOP, ('start',)),
    (LOST, ('stop_without_link',), ('connect',), ('shows', 'Going to 3')),
    (*WE_STOP, LOST, ('connect',), ('shows', 'Stopped')),
    (LOST, ('connect',), ('shows', 'Going to 3'))])
@pytest.mark.parametrize('follows', [(), WE_STOP])
def test_own_epochs_lost_links_and_starts_of_the_controller_are_nobody_elses(missed, follows):
    told = Told()
    told.act(*WE_DRIVE)
    told.tell()
    told.act(*missed)
    if ('start',) in missed:
        told.shows('Going to 3' if len(missed) == 1 else 'Stopped')
    told.act(*follows)
    told.tell()
    assert told.robot.overruled is None


@pytest.mark.parametrize('follows', [(), (('stop_without_link',),)])
def test_a_drive_that_is_lost_before_the_robot_answers_it_is_ours(follows):
    told = Told()
    told.act(('give', OURS, 'goto 3'), LOST, *follows)
    told.tell()
    assert told.robot.overruled is None


def test_a_start_of_the_controller_is_nobodys_act_also_for_a_bridge_that_has_never_driven():
    told = Told()
    told.act(('give', PERSON, 'goto 3'), ('say', 'Going to 3'))
    told.tell()
    told.robot.overruled = None
    told.act(('start',), ('start',))
    told.tell()
    assert told.robot.overruled is None
    told.act(('shows', 'Stopped'), *WE_STOP)
    told.tell()
    assert told.robot.overruled is EpochCause.OTHER_GIVER


MASTER = Giver('/robot/vehicle', 'd')
MASTER_WAITS = ('give', MASTER, 'doTask wait 5'), ('say', 'Doing task wait 5')
MASTER_STOPS = ('give', MASTER, 'stop'), ('say', 'Stopping', 'Stopped')
WE_ARRIVE = ('say', 'Arrived at 3'),


def told_one_by_one(told: Told, *acts) -> None:
    for act in acts:
        told.act(act)
        told.tell()


@pytest.mark.parametrize('acts', [
    MASTER_WAITS, (*MASTER_WAITS, ('say', 'Completed doing task wait 5')),
    (*MASTER_WAITS, *MASTER_STOPS), (*MASTER_WAITS, ('cancel', MASTER)),
    (*MASTER_WAITS, *MASTER_STOPS, *WE_DRIVE, *WE_ARRIVE, *MASTER_WAITS)])
def test_what_the_master_of_the_route_does_itself_overrules_none_of_its_orders(acts):
    told = Told('vehicle')
    told_one_by_one(told, *WE_DRIVE, *WE_ARRIVE)
    told.robot.leave()  # the route is complete
    told_one_by_one(told, *acts)
    assert told.robot.overruled is None


def test_a_drive_that_the_controller_refused_for_an_epoch_of_the_master_is_given_again():
    told = Told('vehicle')
    told_one_by_one(told, *WE_DRIVE, *WE_ARRIVE)
    told.robot.leave()
    known = told.robot.epoch
    told.act(*MASTER_WAITS)
    waits = told_of(told.records.motion)
    told.act(*MASTER_STOPS)
    told.robot.tracker.send('4', 'goto 4')  # the bridge has heard of neither act
    give, = told.robot.due_commands(0.0)
    assert give.known_epoch == known
    stopped = told_of(told.records.motion)
    with pytest.raises(Overruled):
        told.dispatcher.start(parse_command('goto 4'), giver=OURS, known_epoch=known,
                              number=give.number)
    told.robot.update(waits, 0.0)
    told.robot.update(stopped, 0.0)
    told.robot.update(CommandEnded(give.number, Outcome.OVERRULED, ''), 0.0)
    assert told.robot.due_commands(0.0) == []
    told.tell()
    assert told.robot.overruled is None
    assert [again.known_epoch for again in told.robot.due_commands(0.0)] == [told.robot.epoch]


@pytest.mark.parametrize('others', [
    (('give', PERSON, 'stop'), ('say', 'Stopping', 'Stopped')),
    (('say', 'Interrupted: Doing task wait 5', 'Stopping', 'Stopped'),),
    (('say', 'Interrupted: Doing task wait 5'),), (('cancel', PERSON),)])
@pytest.mark.parametrize('is_told', [True, False])
def test_an_act_of_others_between_two_of_the_master_is_known(others, is_told):
    told = Told('vehicle')
    told_one_by_one(told, *WE_DRIVE, *WE_ARRIVE)
    told.robot.leave()
    told_one_by_one(told, *MASTER_WAITS)
    if is_told:
        told_one_by_one(told, *others)
    else:
        told.act(*others)
    told_one_by_one(told, *MASTER_STOPS)
    assert told.robot.overruled is not None


@pytest.mark.parametrize('answered', [True, False])
def test_a_master_that_stops_the_drive_of_its_own_route_takes_it_over(answered):
    told = Told('vehicle')
    told.tell()
    told.robot.tracker.send('3', 'goto 3')
    give, = told.robot.due_commands(0.0)
    told.number = give.number - 1
    told_one_by_one(told, *WE_DRIVE[:1 + answered], *MASTER_STOPS)
    assert told.robot.overruled is EpochCause.OTHER_GIVER


def test_a_program_with_another_name_is_not_the_master():
    told = Told('adapter2')
    told_one_by_one(told, *WE_DRIVE, *WE_ARRIVE)
    told.robot.leave()
    told_one_by_one(told, ('give', PROGRAM, 'goto 4'), ('say', 'Going to 4'))
    assert told.robot.overruled is EpochCause.OTHER_GIVER


def test_each_giver_has_its_own_answer():
    told = Told()
    told.act(*WE_DRIVE, ('give', PERSON, 'stop'))
    persons = told.records.motion.memory.epoch
    told.number = 0
    told.dispatcher.start(parse_command('goto 4'), giver=PROGRAM, number=7)
    told.act(('send',), ('say', 'Stopping', 'Stopped', 'Going to 4'))
    memory = told.records.motion.memory
    assert {last.giver: last.foreign_epoch for last in memory.last_commands} == {
        BRIDGE: memory.epoch, PROGRAM.name: persons}


@pytest.mark.parametrize('ends, motions', [(0.0, 0.0), (0.2, 0.0), (0.0, 0.2)])
def test_a_route_that_fails_with_its_link_is_not_taken_over_as_the_link_comes_back(ends, motions):
    world = Witness('rolling', Delays(ends=ends, motions=motions), dialect='interrupted name')
    world.order(7, 1, 2)
    world.run(2.0)
    world.cut(RobotLink.COMMANDS, 6.0)
    world.run(15.0)
    assert world.bridge.report().cause is EpochCause.LOST_LINK
