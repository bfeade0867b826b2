"""The records of drives show which giver moves the robot, and whether the robot obeys.

No drive is sent after a stop or drive that its giver does not know of. A stop is owed until the
robot has obeyed it.
"""
from __future__ import annotations

from contextlib import nullcontext
from typing import Optional, Tuple

import pytest
from arcl_builders import outcome
from drive_bench import DOCKED, DOCKING, OTHER, PERSON, ROUTE, UNDOCKED, UNDOCKING, Bench

from omron_arcl import Busy, Giver, Outcome, parse_command
from omron_arcl.drives import LOOK, MOST_OPEN, RETRY, Overruled, Unclear, draw_epoch
from omron_arcl.records import CommandFate, DriveMemory, Fate, MotionCause, MotionState, RecordKind


@pytest.fixture
def bench() -> Bench:
    return Bench()


class TestEpochs:
    def test_one_is_random_and_never_0(self):
        assert len({draw_epoch() for _ in range(100)}) == 100
        assert all(0 < draw_epoch() < 2 ** 64 for _ in range(100))

    def test_one_lasts_while_one_giver_drives(self, bench):
        bench.drive(ROUTE, 'goto 1')
        bench.robot('Going to 1')
        epoch = bench.epoch
        bench.drive(ROUTE, 'goto 2', known_epoch=epoch)
        bench.robot('Going to 2')
        assert (bench.epoch, bench.memory.giver, bench.memory.cause) == (
            epoch, ROUTE, MotionCause.OTHER_GIVER)

    @pytest.mark.parametrize(('does', 'cause'), [
        (lambda bench: (bench.drive(PERSON, 'goto 3'), bench.robot('Going to 3')),
         MotionCause.OTHER_GIVER),
        (lambda bench: bench.stop(PERSON), MotionCause.STOP),
        (lambda bench: bench.robot('Stopping'), MotionCause.OTHER_CLIENT),
        (lambda bench: bench.robot('Going to 9'), MotionCause.OTHER_CLIENT),
        (lambda bench: bench.robot('EStop pressed'), MotionCause.EMERGENCY_STOP),
        (lambda bench: bench.status('Teleop driving', 2.0), MotionCause.OTHER_CLIENT)])
    def test_another_begins_with_what_others_do_and_the_driver_does_not_pass_it(
            self, bench, does, cause):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.pass_time(2.0)
        known = bench.epoch
        does(bench)
        # if only a status shows the change, the status must last for some time
        if cause is MotionCause.OTHER_CLIENT and bench.epoch == known:
            bench.status('Teleop driving', 5.0)
            bench.pass_time(5.0)
        assert (bench.memory.cause, bench.memory.previous_epoch) == (cause, known)
        with pytest.raises(Overruled):
            bench.drive(ROUTE, 'goto 14', known_epoch=known)
        bench.drive(ROUTE, 'goto 14', known_epoch=bench.epoch)

    def test_who_did_all_that_came_since_knows_of_it_before_it_is_told(self, bench):
        known = bench.epoch
        bench.drive(ROUTE, known_epoch=known)
        bench.stop(ROUTE, known_epoch=known)
        bench.drive(ROUTE, 'goto 14', known_epoch=known)
        assert bench.sent == ['goto 12', 'stop', 'goto 14']

    def test_a_giver_that_was_restarted_is_another_one(self, bench):
        known = bench.epoch
        bench.drive(ROUTE, known_epoch=known)
        bench.robot('Going to 12')
        with pytest.raises(Overruled):
            bench.drive(Giver(ROUTE.name, 'another process'), known_epoch=known)

    def test_a_persons_own_stop_is_not_passed_by_software_that_knew_only_of_the_drive(self, bench):
        """Once, it depended on chance whether the stop counted as one of the program's own."""
        bench.drive(PERSON, 'goto 3')
        known = bench.epoch
        bench.stop(PERSON)
        with pytest.raises(Overruled, match='"stop" of /rviz'):
            bench.drive(ROUTE, known_epoch=known)

    def test_no_time_lets_a_drive_pass(self, bench):
        known = bench.epoch
        bench.stop(PERSON)
        bench.robot('Stopping')
        bench.robot('Stopped')
        bench.pass_time(3600.0)
        with pytest.raises(Overruled):
            bench.drive(ROUTE, known_epoch=known)

    def test_two_programs_that_alternate_are_told_and_decide_again(self, bench):
        known = bench.epoch
        bench.drive(ROUTE, known_epoch=known)
        bench.robot('Going to 12')
        with pytest.raises(Overruled):
            bench.drive(OTHER, 'goto 3', known_epoch=known)
        bench.drive(OTHER, 'goto 3', known_epoch=bench.epoch)

    def test_a_persons_command_counts_in_any_epoch(self, bench):
        bench.drive(ROUTE)
        bench.drive(PERSON, 'goto 3')
        assert bench.sent == ['goto 12', 'goto 3']

    def test_an_epoch_of_which_nothing_is_known_any_more_is_over(self, bench):
        with pytest.raises(Overruled):
            bench.drive(ROUTE, known_epoch=7)

    def test_a_start_begins_one_and_names_the_one_before(self):
        bench = Bench(DriveMemory(55, cause=MotionCause.STOP))
        assert (bench.memory.cause, bench.memory.previous_epoch) == (MotionCause.RESTART, 55)
        assert bench.kept[0] == bench.memory, 'the memory must be stored before anything is sent'

    def test_what_changes_is_kept_before_it_is_sent(self, bench):
        del bench.kept[:]
        bench.dispatcher.start(parse_command('goto 12'), giver=ROUTE)
        assert bench.sent == []
        record = bench.kept[-1].records[-1]
        assert (record.giver, record.goal, record.fate) == (ROUTE, '12', Fate.GIVEN)

    @pytest.mark.parametrize('text', ['getGoals', 'say hello', 'localizeToPoint 0 0 0'])
    def test_what_does_not_move_the_robot_changes_nothing(self, bench, text):
        before = bench.memory
        bench.give(text, giver=PERSON)
        assert bench.memory == before

    def test_the_next_emergency_stop_begins_one_before_any_status_is_seen(self, bench):
        bench.robot('EStop pressed')
        first = bench.epoch
        bench.robot('EStop relieved but motors still disabled', 'Motors enabled', 'EStop pressed')
        assert bench.epoch != first

    def test_an_emergency_stop_begins_one_each_time(self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        epochs = set()
        for _ in range(2):
            bench.robot('EStop pressed')
            bench.status('EStop pressed')
            epochs.add(bench.epoch)
            bench.status('Stopped')
        assert len(epochs) == 2


class TestWhatIsNotSentYet:
    def test_a_drive_is_checked_again_when_it_could_go(self, bench):
        """A line of the robot may arrive after the drive was given and before it is sent."""
        drive = bench.dispatcher.start(parse_command('goto 12'), giver=ROUTE,
                                       known_epoch=bench.epoch)
        bench.robot('Stopping')
        assert bench.sent == []
        assert drive.result.outcome is Outcome.OVERRULED

    def test_a_stop_drops_it_and_tells_by_whose_word(self, bench):
        own = bench.dispatcher.start(parse_command('goto 12'), giver=ROUTE)
        theirs = bench.dispatcher.start(parse_command('goto 3'), giver=OTHER)
        bench.stop(ROUTE)
        assert (own.result.outcome, theirs.result.outcome) == (
            Outcome.CANCELLED, Outcome.OVERRULED)
        assert bench.sent == ['stop']

    def test_what_was_not_sent_when_the_link_broke_is_told_by_a_code(self, bench):
        """Once, programs had to find this out from the words of the result."""
        sent = bench.drive(ROUTE)
        unsent = bench.dispatcher.start(parse_command('goto 14'), giver=ROUTE)
        bench.lose()
        assert (sent.result.outcome, unsent.result.outcome) == (Outcome.LOST, Outcome.NEVER_SENT)


class TestAnotherClientOfTheRobot:
    @pytest.mark.parametrize('refusal', [
        ('Unknown command dock',), ('CommandError: dock', 'CommandErrorDescription: not today')])
    @pytest.mark.parametrize('arrives', [(), ('Arrived at 3',)])
    def test_a_robot_that_seemed_to_set_out_for_a_refused_drive_does_so_for_others(
            self, bench, arrives, refusal):
        bench.status('Going to 5')
        stop = bench.stop(ROUTE)
        bench.robot('Stopping')
        dock = bench.drive(OTHER, 'dock')
        bench.robot('Going to 3', *arrives, *refusal)
        assert outcome(dock) in (Outcome.REJECTED, Outcome.UNKNOWN_COMMAND)
        assert bench.memory.ruling.kind is RecordKind.FOREIGN_DRIVE
        assert (outcome(stop), bench.memory.stop_owed) == (Outcome.INTERRUPTED, False)

    def test_a_stop_after_that_motion_and_before_the_refusal_is_the_newer_act_of_others(
            self, bench):
        bench.status('Stopped')
        bench.drive(OTHER, 'dock')
        bench.robot('Going to 3', 'Stopping', 'Stopped', 'Unknown command dock')
        assert bench.memory.ruling.kind is RecordKind.FOREIGN_STOP

    @pytest.mark.parametrize(('text', 'motion'), [
        ('goto 12', 'Going to 12'), ('gotoPoint 1 2', 'Going to point'),
        ('doTask wait 1', 'Doing task wait 1')])
    def test_a_drive_to_our_goal_after_its_stop_is_not_ours(self, bench, text, motion):
        """This holds although our command has not ended yet, because no line has named it."""
        bench.drive(ROUTE, text)
        bench.robot(motion, 'Stopping')
        known = bench.epoch
        bench.robot(motion)
        assert bench.memory.ruling.kind is RecordKind.FOREIGN_DRIVE
        assert bench.epoch != known
        with pytest.raises(Overruled):
            bench.drive(OTHER, 'goto 3', known_epoch=known)

    def test_a_robot_that_obeys_our_stop_was_stopped_by_us(self, bench):
        bench.drive(ROUTE)
        bench.stop(ROUTE)
        known = bench.epoch
        bench.robot('Stopping', 'Stopped')
        assert bench.epoch == known
        bench.robot('Stopping')
        assert bench.memory.cause is MotionCause.OTHER_CLIENT, 'one stop gets one `Stopping`'

    def test_nor_one_that_stops_for_an_instant_to_replace_a_drive(self, bench):
        bench.drive(ROUTE, 'goto 1')
        bench.robot('Going to 1')
        bench.pass_time(5.0)
        bench.drive(ROUTE, 'goto 2')
        known = bench.epoch
        bench.robot('Stopping')
        bench.robot('Going to 2')
        assert bench.epoch == known
        assert not bench.memory.stop_owed

    @pytest.mark.parametrize('line', ['Motors enabled', None])
    def test_nor_one_that_stops_by_itself(self, bench, line):
        if line:
            bench.robot(line)
        else:
            bench.drive(ROUTE, 'undock')
            bench.robot('DockingState: Undocking ForcedState: Unforced ChargeState: Not')
            bench.robot(UNDOCKED)
        known = bench.epoch
        bench.robot('Stopping')
        assert bench.epoch == known

    @pytest.mark.parametrize(('command', 'lines'), [
        ('dock', [UNDOCKED, DOCKING]),
        ('goto 12', ['DockingState: Undocking ForcedState: Unforced ChargeState: Not', UNDOCKED])])
    def test_nor_one_that_stops_by_itself_about_its_dock(self, bench, command, lines):
        bench.status('DockingState: Docked ForcedState: Unforced ChargeState: Bulk')
        bench.drive(ROUTE, command)
        bench.robot(*lines)
        bench.pass_time(2.0)
        known = bench.epoch
        bench.robot('Stopping', 'Stopped')
        assert bench.epoch == known

    def test_a_drive_that_may_have_been_on_the_wire_leaves_a_stop_owed(self, bench):
        bench.status('Stopped')
        bench.drive(ROUTE)
        bench.robot('Stopping')
        bench.send()
        assert bench.sent == ['goto 12', 'stop']
        assert bench.memory.cause is MotionCause.OTHER_CLIENT

    def test_also_one_that_was_to_replace_another(self, bench):
        bench.drive(ROUTE, 'goto 1')
        bench.robot('Going to 1')
        bench.pass_time(5.0)
        bench.drive(ROUTE, 'goto 2')
        bench.robot('Stopping')
        bench.robot('Stopped')
        bench.send()
        assert bench.sent[-1] == 'stop'

    def test_nothing_is_sent_while_it_is_not_known_whether_the_robot_obeys(self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.status('Stopped', 2.0)
        with pytest.raises(Unclear):
            bench.drive(ROUTE, 'goto 14', known_epoch=bench.epoch)
        bench.status('Going to 12')
        bench.drive(ROUTE, 'goto 14', known_epoch=bench.epoch)

    def test_one_that_drives_an_idle_robot_is_seen_by_the_status(self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.robot('Arrived at 12')
        known = bench.epoch
        for _ in range(3):
            bench.status('Going to 9', 1.0)
        assert bench.epoch != known
        assert bench.memory.cause is MotionCause.OTHER_CLIENT

    def test_one_that_stops_a_robot_at_its_goal_is_seen_by_the_status(self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.robot('Arrived at 12')
        bench.status('Arrived at 12')
        known = bench.epoch
        bench.status('Stopped')
        assert bench.epoch != known

    def test_a_robot_that_docks_by_itself_is_told_so(self, bench):
        bench.robot(UNDOCKED)
        bench.robot(DOCKING)
        assert bench.memory.cause is MotionCause.ROBOT


class TestAfterAnOutage:
    """No program continues a drive if a person stopped the robot while there was no link."""

    @staticmethod
    def after(outage: str, text: str = 'goto 12', *said: str) -> Tuple[Bench, int]:
        """Plays a drive, an outage and a new connection. Returns the bench and the new epoch."""
        bench = Bench()
        bench.status('Stopped')
        bench.drive(ROUTE, text)
        bench.robot(*said)
        if outage == 'restart':
            again = Bench(bench.kept[-1])
            assert again.memory.previous_epoch == bench.epoch
            return again, again.epoch
        bench.lose()
        bench.pass_time(10.0)
        bench.connect()
        return bench, bench.epoch

    @pytest.mark.parametrize('shown', ['Going to 12', 'Arrived at 12'])
    def test_the_giver_of_a_lost_drive_does_not_pass_the_one_whose_drive_went_on(
            self, bench, shown):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.drive(OTHER, 'goto 3')
        bench.lose()
        bench.connect()
        known = bench.epoch
        bench.status(shown)
        bench.drive(ROUTE, 'goto 14', known_epoch=bench.epoch)
        bench.robot('Going to 14')
        with pytest.raises(Overruled):
            bench.drive(PERSON, 'goto 9', known_epoch=known)

    @pytest.mark.parametrize(('text', 'motion'), [
        ('goto 12', 'Going to 12'), ('gotoPoint 1 2', 'Going to point'), ('dock', 'Docking'),
        ('patrolOnce a', 'Patrolling route a once')])
    @pytest.mark.parametrize('stops', [False, True])
    def test_a_lost_drive_that_the_robot_broke_off_does_not_begin_late(self, text, motion, stops):
        """After the robot has broken off our drive, another client drives it to the same goal."""
        bench, _ = self.after('lost link', text)
        if stops:
            bench.stop(PERSON)
        bench.robot(UNDOCKED, f'Interrupted: {motion}', *['Stopping'] * stops)
        known = bench.epoch
        bench.robot(DOCKING if motion == 'Docking' else motion)
        assert bench.epoch != known
        assert bench.memory.ruling.kind is RecordKind.FOREIGN_DRIVE
        assert not bench.memory.stop_owed, 'the drive of another client is not stopped'

    def test_a_drive_that_began_late_and_was_stopped_does_not_begin_again(self, bench):
        bench.drive(ROUTE)
        bench.robot('EStop pressed', 'EStop relieved and motors still disabled', 'Motors enabled')
        bench.send()
        bench.robot('Going to 12', 'Interrupted: Going to 100 200', 'Stopping')
        assert bench.memory.stop_owed
        bench.robot('Going to 12')
        assert bench.memory.ruling.kind is RecordKind.FOREIGN_DRIVE
        assert not bench.memory.stop_owed, 'the drive of another client is not stopped'

    def test_nor_does_an_older_drive_to_the_same_goal(self, bench):
        """The robot began one of two lost drives, and was stopped: both are over."""
        for giver in (ROUTE, OTHER):
            bench.drive(giver)
        bench.lose()
        bench.connect()
        bench.stop(PERSON)
        bench.robot('Going to 12', 'Interrupted: Going to 100 200', 'Stopping')
        assert bench.memory.stop_owed
        bench.robot('Going to 12')
        assert bench.memory.ruling.kind is RecordKind.FOREIGN_DRIVE
        assert not bench.memory.stop_owed, 'the drive of another client is not stopped'

    def test_a_drive_that_is_to_be_answered_is_not_the_one_that_was_broken_off(self, bench):
        bench.status('Going to 12')
        bench.drive(ROUTE, 'goto 12')
        bench.robot('EStop pressed', 'EStop relieved and motors still disabled')
        assert bench.memory.stop_owed
        bench.robot('Interrupted: Going to 12', 'Motors enabled', 'Going to 12')
        assert bench.memory.stop_owed, 'the drive that was on its way is to be stopped'

    @pytest.mark.parametrize('outage', ['lost link', 'restart'])
    @pytest.mark.parametrize('shown', [
        'Stopped', 'Stopping', 'Arrived at 5', 'Going to 5', 'Teleop driving', DOCKED, 'Parked',
        'Failed going to 12', 'Robot lost', 'Motors disabled', 'Interrupted: Going to 12',
        'EStop pressed', 'a text of no known kind'])
    def test_a_robot_that_does_not_show_our_drive_has_a_new_epoch(self, outage, shown):
        bench, known = self.after(outage, 'goto 12', 'Going to 12')
        bench.status(shown)
        assert bench.epoch != known
        with pytest.raises(Overruled):
            bench.drive(ROUTE, 'goto 14', known_epoch=known)

    @pytest.mark.parametrize('outage', ['lost link', 'restart'])
    @pytest.mark.parametrize(('text', 'line', 'shown'), [
        ('goto 12', 'Going to 12', 'Going to 12'), ('goto 12', 'Going to 12', 'Arrived at 12'),
        ('gotoPoint 1 2', 'Going to point', 'Going to point'), ('dock', DOCKING, DOCKED),
        ('dock', DOCKING, DOCKING), ('patrolOnce a', 'Patrolling route a once',
                                     'Finished patrolling route a')])
    def test_one_that_shows_it_under_way_or_completed_goes_on(self, outage, text, line, shown):
        bench, known = self.after(outage, text, line)
        bench.status(shown)
        assert bench.epoch == known
        bench.drive(ROUTE, 'goto 14', known_epoch=known)

    def test_the_drive_that_the_robot_shows_is_the_one_under_way(self):
        bench, known = self.after('lost link', 'goto 12', 'Going to 12')
        bench.status('Going to 12')
        bench.drive(ROUTE, 'goto 14')
        bench.lose()
        bench.connect()
        bench.status('Going to 12')
        assert (bench.epoch, bench.memory.goal, bench.memory.giver) == (known, '12', ROUTE)

    @pytest.mark.parametrize('end', ['Arrived at 12', 'Stopped'])
    def test_the_statuses_show_the_end_of_a_drive_whose_command_was_lost(self, end):
        bench, known = self.after('lost link', 'goto 12', 'Going to 12')
        bench.status('Going to 12')
        for _ in range(3):
            bench.status(end, 1.0)
        assert (bench.epoch == known, bench.state) == (end != 'Stopped', MotionState.STANDING)

    def test_one_that_we_stopped_does_not_drive_to_our_goal_because_of_us(self):
        bench, _ = self.after('lost link', 'goto 12', 'Going to 12')
        bench.status('Going to 12')
        bench.stop(ROUTE)
        bench.robot('Stopping', 'Stopped')
        bench.lose()
        bench.connect()
        known = bench.epoch
        bench.status('Going to 12')
        assert (bench.epoch != known, bench.memory.cause) == (True, MotionCause.OTHER_CLIENT)

    @pytest.mark.parametrize('outage', ['lost link', 'restart'])
    def test_one_that_we_stopped_and_that_stands_was_not_driven_by_another_client(self, outage):
        bench = Bench()
        bench.stop(ROUTE)
        bench.robot('Stopping', 'Stopped')
        if outage == 'restart':
            bench = Bench(bench.kept[-1])
        else:
            bench.lose()
            bench.connect()
        known = bench.epoch
        bench.status('Stopped')
        assert (bench.epoch != known, bench.memory.cause) == (True, MotionCause.RESTART)
        with pytest.raises(Overruled):
            bench.drive(ROUTE, known_epoch=known)

    @pytest.mark.parametrize('shown_before, cause', [
        ('Docked', MotionCause.RESTART), ('Stopped', MotionCause.OTHER_CLIENT)])
    def test_one_that_we_stopped_in_its_dock_was_docked_by_others_only_if_it_showed_no_dock_before(
            self, shown_before, cause):
        bench = Bench()
        bench.stop(ROUTE)
        bench.robot('Stopping', 'Stopped')
        bench.status(shown_before)
        bench = Bench(bench.kept[-1])
        bench.status('Docked')
        assert bench.memory.cause is cause

    @pytest.mark.parametrize('shown', ['Stopped', DOCKED])
    def test_a_first_connection_that_is_refused_before_is_no_outage(self, shown):
        bench = Bench(is_linked=False)
        known = bench.epoch
        bench.lose()
        bench.connect()
        bench.status(shown)
        assert (bench.epoch, bench.memory.cause) == (known, MotionCause.RESTART)

    @pytest.mark.parametrize('outage', ['lost link', 'restart'])
    def test_no_program_drives_before_the_robot_has_said_what_it_does(self, outage):
        bench, known = self.after(outage, 'goto 12', 'Going to 12')
        with pytest.raises(Unclear):
            bench.drive(ROUTE, 'goto 14', known_epoch=known)

    @pytest.mark.parametrize('command', ['goto 14', 'stop'])
    def test_a_command_for_any_epoch_does_not_hide_what_others_did(self, command):
        bench, known = self.after('lost link', 'goto 12', 'Going to 12')
        bench.give(command, giver=ROUTE)
        with pytest.raises(Overruled):
            bench.drive(ROUTE, 'goto 15', known_epoch=known)
        bench.robot('Stopped' if command == 'stop' else 'Going to 14')
        assert bench.memory.giver == ROUTE


class TestOwedStop:
    def test_it_ends_when_the_robot_has_obeyed(self, bench):
        bench.drive(ROUTE)
        bench.stop(PERSON)
        assert bench.memory.stop_owed
        bench.robot('Going to 12')
        bench.robot('Stopping')
        bench.robot('Stopped')
        assert not bench.memory.stop_owed

    def test_or_when_it_obeys_a_newer_drive(self, bench):
        bench.drive(ROUTE)
        bench.stop(ROUTE)
        bench.drive(PERSON, 'goto 3')
        assert bench.memory.stop_owed, 'the drive may be lost'
        bench.robot('Going to 3')
        assert not bench.memory.stop_owed

    def test_or_when_it_completes_a_newer_drive_at_once(self, bench):
        bench.lose()
        bench.stop_without_link(ROUTE)
        bench.connect()
        drive = bench.drive(PERSON, 'goto 3')
        bench.robot('Arrived at 3')
        bench.pass_time(2 * LOOK)
        assert (outcome(drive), bench.sent) == (Outcome.SUCCEEDED, ['goto 3'])
        assert (bench.memory.giver, bench.memory.stop_owed) == (PERSON, False)

    def test_one_that_was_refused_is_sent_again(self, bench):
        bench.stop(PERSON)
        bench.robot('Unknown command stop')
        bench.pass_time(RETRY / 2)
        assert bench.sent == ['stop']
        bench.pass_time(RETRY)
        assert bench.sent == ['stop', 'stop']

    @pytest.mark.parametrize('shown', ['Going to 12', 'Stopped', 'Going to point', 'Patrolling a'])
    def test_without_a_link_it_is_sent_as_soon_as_the_robot_can_be_reached(self, bench, shown):
        """This also holds if the robot's status names no goal."""
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.lose()
        bench.stop_without_link(PERSON)
        bench.pass_time(60.0)
        assert bench.sent == ['goto 12']
        bench.connect()
        bench.status(shown)
        bench.send()
        assert bench.sent == ['goto 12', 'stop']

    def test_a_robot_that_shows_nothing_gets_it_soon(self, bench):
        bench.stop(PERSON)
        bench.lose()
        bench.connect()
        bench.pass_time(LOOK)
        assert bench.sent == ['stop', 'stop']

    @pytest.mark.parametrize('shown', ['Going to 9', 'Teleop driving'])
    def test_it_does_not_end_the_newer_drive_of_another_client(self, bench, shown):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.lose()
        bench.stop_without_link(ROUTE)
        bench.connect()
        bench.status(shown)
        bench.pass_time(2 * LOOK)
        assert bench.sent == ['goto 12']
        assert (bench.memory.stop_owed, bench.memory.cause) == (False, MotionCause.OTHER_CLIENT)

    @pytest.mark.parametrize('shown', ['Going to 9', 'Teleop driving', 'Going to point'])
    @pytest.mark.parametrize('outage', ['link', 'restart'])
    def test_it_ends_the_drive_of_another_client_that_was_there_before_it(self, bench, shown,
                                                                          outage):
        """A person stops a robot that another client drives, and the link breaks at that moment."""
        for _ in range(3):
            bench.status(shown, 1.0)
        bench.stop(PERSON)
        if outage == 'link':
            bench.lose()
            bench.connect()
        else:
            bench = Bench(bench.kept[-1])
        sent = len(bench.sent)
        bench.status(shown)
        bench.pass_time(2 * LOOK)
        assert bench.sent[sent:sent + 1] == ['stop']

    def test_it_outlives_a_restart(self, bench):
        bench.drive(ROUTE)
        bench.stop(PERSON)
        again = Bench(bench.kept[-1])
        again.status('Going to 12')
        again.send()
        assert again.sent == ['stop']

    def test_after_a_restart_a_newer_drive_of_another_client_ends_it(self, bench):
        bench.drive(ROUTE)
        bench.stop(PERSON)
        again = Bench(bench.kept[-1])
        again.status('Going to 9')
        again.pass_time(2 * LOOK)
        assert again.sent == []

    def test_a_stop_for_an_epoch_that_a_newer_drive_has_ended_is_not_sent(self, bench):
        bench.drive(ROUTE)
        known = bench.epoch
        bench.drive(PERSON, 'goto 3')
        bench.robot('Going to 3')
        with pytest.raises(Overruled):
            bench.stop(ROUTE, known_epoch=known)
        assert bench.sent == ['goto 12', 'goto 3']

    def test_a_stop_is_sent_while_the_robot_has_not_answered_another_drive(self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        known = bench.epoch
        bench.drive(PERSON, 'goto 3')
        bench.stop(ROUTE, known_epoch=known)
        assert bench.sent == ['goto 12', 'goto 3', 'stop']

    def test_nor_is_it_owed_where_there_is_no_link(self, bench):
        bench.drive(ROUTE)
        known = bench.epoch
        bench.drive(PERSON, 'goto 3')
        bench.robot('Going to 3')
        bench.lose()
        with pytest.raises(Overruled):
            bench.stop_without_link(ROUTE, known)
        assert not bench.memory.stop_owed

    def test_a_newer_drive_whose_end_was_lost_with_the_link_is_not_ended_by_it(self, bench):
        bench.drive(ROUTE)
        bench.stop(ROUTE)
        bench.drive(PERSON, 'goto 3')
        bench.lose()
        assert bench.memory.stop_owed, 'the stop may also be lost'
        bench.connect()
        bench.status('Going to 3')
        bench.pass_time(2 * LOOK)
        assert bench.sent == ['goto 12', 'stop', 'goto 3']

    @pytest.mark.parametrize('end', ['EStop pressed', 'Stopping'])
    def test_a_stop_for_one_that_anything_else_has_ended_is_sent(self, bench, end):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.pass_time(2.0)
        known = bench.epoch
        bench.robot(end)
        bench.stop(ROUTE, known_epoch=known)
        assert bench.sent[-1] == 'stop'

    def test_a_persons_stop_is_always_sent(self, bench):
        bench.drive(ROUTE)
        bench.drive(OTHER, 'goto 3')
        bench.stop(PERSON)
        assert bench.sent[-1] == 'stop'

    def test_a_cancellation_is_a_stop(self, bench):
        drive = bench.drive(ROUTE)
        bench.robot('Going to 12')
        known = bench.epoch
        bench.dispatcher.cancel(drive, bench.now, PERSON)
        bench.send()
        assert bench.sent == ['goto 12', 'stop']
        assert bench.memory.cause is MotionCause.CANCEL
        with pytest.raises(Overruled, match='a cancellation of /rviz'):
            bench.drive(ROUTE, known_epoch=known)

    @pytest.mark.parametrize('is_sent', [True, False])
    def test_the_cancellation_by_another_is_a_stop_also_of_a_drive_that_does_not_rule(
            self, bench, is_sent):
        """Otherwise no epoch would show the giver of the drive why the drive was cancelled."""
        if is_sent:
            drive = bench.drive(ROUTE)
            bench.robot('Going to 12')
            bench.drive(OTHER, 'goto 3')
        else:
            drive = bench.dispatcher.start(parse_command('goto 12'), giver=ROUTE)
        known = bench.epoch
        bench.dispatcher.cancel(drive, bench.now, PERSON)
        assert (bench.memory.cause, bench.memory.stop_owed) == (MotionCause.CANCEL, True)
        assert not bench.records.knows(ROUTE, known)

    def test_the_cancellation_of_an_older_drive_does_not_end_a_newer_one_of_a_person(self, bench):
        drive = bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.drive(PERSON, 'goto 3')
        bench.dispatcher.cancel(drive, bench.now, ROUTE)
        bench.pass_time(30.0)
        assert bench.sent == ['goto 12', 'goto 3']

    @pytest.mark.parametrize('outage', ['lost link', 'restart'])
    @pytest.mark.parametrize('newer', [PERSON, ROUTE])
    @pytest.mark.parametrize(('shown', 'is_stopped'), [
        ('Going to 12', True), ('Going to 3', False), ('Arrived at 12', False)])
    def test_a_cancelled_drive_whose_replacement_was_lost_is_stopped(
            self, bench, outage, newer, shown, is_stopped):
        """Otherwise the robot would carry out a drive that its giver has cancelled."""
        drive = bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.drive(newer, 'goto 3')
        bench.dispatcher.cancel(drive, bench.now, ROUTE)
        if outage == 'restart':
            bench = Bench(bench.kept[-1], first_epoch=201)
        else:
            bench.lose()
            bench.connect()
        known = bench.epoch
        bench.status(shown)
        bench.pass_time(0.1)
        assert (bench.memory.stop_owed, bench.sent[-1:] == ['stop']) == (is_stopped, is_stopped)
        if is_stopped:
            assert bench.memory.cause is MotionCause.CANCEL
            assert not bench.records.knows(PERSON, known)
            bench.robot('Interrupted: Going to 12', 'Stopping', 'Stopped')
            assert not bench.memory.stop_owed

    @pytest.mark.parametrize('newer', [PERSON, ROUTE])
    @pytest.mark.parametrize('by_line', [True, False])
    @pytest.mark.parametrize(('goal', 'is_stopped'), [('12', True), ('3', False)])
    def test_also_if_the_robot_leaves_its_dock_first_and_names_no_goal(
            self, bench, newer, by_line, goal, is_stopped):
        bench.robot(DOCKED)
        drive = bench.drive(ROUTE)
        bench.robot(UNDOCKING)
        bench.drive(newer, 'goto 3')
        bench.dispatcher.cancel(drive, bench.now, ROUTE)
        bench.lose()
        bench.connect()
        bench.status('Undocking')
        assert (bench.memory.giver.name, bench.memory.stop_owed) == ('', False)
        if by_line:
            bench.robot(f'Going to {goal}')
        else:
            bench.status(f'Going to {goal}', 1.5)
        bench.pass_time(0.1)
        assert (bench.memory.stop_owed, bench.sent[-1:] == ['stop']) == (is_stopped, is_stopped)
        assert bench.memory.giver == (ROUTE if is_stopped else newer)

    @pytest.mark.parametrize('newer', [PERSON, ROUTE])
    def test_a_robot_that_has_left_its_dock_obeys_the_giver_of_the_goal_that_it_names(
            self, bench, newer):
        bench.robot(DOCKED)
        bench.drive(ROUTE)
        bench.robot(UNDOCKING)
        bench.drive(newer, 'goto 3')
        bench.lose()
        bench.connect()
        bench.status('Undocking')
        bench.robot('Going to 12')
        assert (bench.memory.giver, bench.memory.goal) == (ROUTE, '12')

    def test_also_if_the_robot_said_nothing_and_shows_the_cancelled_drive_late(self, bench):
        drive = bench.drive(ROUTE, timeout=3.0)
        bench.robot('Going to 12')
        newer = bench.drive(PERSON, 'goto 3', timeout=3.0)
        bench.dispatcher.cancel(drive, bench.now, ROUTE)
        bench.pass_time(4.0)
        assert (outcome(drive), outcome(newer)) == (Outcome.TIMED_OUT, Outcome.TIMED_OUT)
        assert bench.sent == ['goto 12', 'goto 3']
        bench.status('Going to 12')
        bench.pass_time(0.1)
        assert bench.sent == ['goto 12', 'goto 3', 'stop']

    def test_a_stop_that_a_drive_has_followed_does_not_obey_the_cancellation_of_that_drive(
            self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.stop(ROUTE)
        bench.drive(PERSON, 'goto 13')
        bench.records.all_cancelled(PERSON)
        bench.robot('Stopping')
        bench.robot('Stopped')
        assert bench.memory.stop_owed, 'the robot has not received that drive yet'
        bench.pass_time(0.1)
        assert bench.sent == ['goto 12', 'stop', 'goto 13', 'stop']
        bench.robot('Going to 13')
        bench.robot('Stopping')
        bench.robot('Stopped')
        assert not bench.memory.stop_owed

    def test_a_cancellation_while_the_robot_rests_refuses_the_drives_on_their_way_and_sends_no_stop(
            self, bench):
        bench.status('Stopped')
        known = bench.epoch
        bench.records.all_cancelled(PERSON)
        assert (bench.memory.cause, bench.memory.previous_epoch) == (MotionCause.CANCEL, known)
        with pytest.raises(Overruled):
            bench.drive(ROUTE, known_epoch=known)
        bench.drive(ROUTE, 'goto 3', known_epoch=bench.epoch)
        bench.robot('Going to 3')
        bench.pass_time(RETRY)
        assert (bench.memory.giver, bench.sent) == (ROUTE, ['goto 3'])

    def test_a_new_stop_does_not_wait_for_the_next_try_of_an_older_one(self, bench):
        bench.stop(ROUTE)
        bench.robot('Stopping', 'Stopped')
        bench.drive(PERSON, 'goto 4')
        bench.records.all_cancelled(PERSON)
        bench.pass_time(0.0)
        assert bench.sent == ['stop', 'goto 4', 'stop']

    def test_a_cancelled_drive_is_stopped_although_another_clients_drive_is_heard_first(
            self, bench):
        bench.drive(PERSON, 'goto 4')
        bench.records.all_cancelled(PERSON)
        bench.robot('Going to 3')  # sent before `goto 4` reached the robot
        assert bench.memory.cause is MotionCause.OTHER_CLIENT
        assert bench.sent == ['goto 4', 'stop'], 'otherwise the robot would drive on to 4'

    def test_a_drive_on_its_way_is_stopped_that_an_emergency_stop_seems_to_have_ended(self, bench):
        bench.drive(PERSON, 'goto 4')
        bench.robot('EStop pressed')  # sent before `goto 4` reached the robot
        bench.records.all_cancelled(PERSON)
        bench.robot('EStop relieved but motors still disabled', 'Motors enabled', 'Going to 4')
        assert bench.sent == ['goto 4', 'stop']

    def test_a_drive_after_an_older_stop_is_stopped_although_another_client_drives_meanwhile(
            self, bench):
        bench.stop(PERSON)
        bench.drive(PERSON, 'goto 4')
        bench.robot('Going to 3', 'Stopping')
        bench.records.all_cancelled(PERSON)
        bench.robot('Going to 4')
        bench.pass_time(RETRY)
        assert bench.sent[:2] == ['stop', 'goto 4']
        assert 'stop' in bench.sent[2:]

    def test_another_clients_drive_long_after_ours_ends_the_stop_that_is_owed(self, bench):
        bench.drive(PERSON, 'goto 4')
        bench.robot('Going to 4')
        bench.records.all_cancelled(PERSON)
        bench.robot('Going to 3')
        assert not bench.memory.stop_owed
        assert bench.sent == ['goto 4']


class TestInterruption:
    """No source says whether `Interrupted` comes before the line about an emergency stop."""

    @pytest.mark.parametrize('then, cause', [
        ('EStop pressed', MotionCause.EMERGENCY_STOP), ('Stopping', MotionCause.OTHER_CLIENT),
        ('Going to 9', MotionCause.OTHER_CLIENT),
        ('status EStop pressed', MotionCause.EMERGENCY_STOP),
        ('status Stopped', MotionCause.OTHER_CLIENT),
        ('status Going to 9', MotionCause.OTHER_CLIENT)])
    def test_the_next_line_about_the_motion_tells_why_and_begins_another_epoch(
            self, bench, then, cause):
        drive = bench.drive(ROUTE)
        bench.robot('Going to 12', 'Interrupted: Going to 12')
        unexplained = bench.epoch
        assert outcome(drive) is Outcome.INTERRUPTED
        assert bench.memory.cause is MotionCause.INTERRUPTED
        assert bench.dispatcher.in_doubt, 'a status would help'
        for giver in (ROUTE, OTHER):
            with pytest.raises(Unclear, match='why it broke off its drive'):
                bench.drive(giver, known_epoch=unexplained)
        if then.startswith('status'):
            bench.status(then[len('status '):])
        else:
            bench.robot(then)
        assert bench.memory.cause is cause
        assert not bench.dispatcher.in_doubt
        for giver in (ROUTE, OTHER):
            with pytest.raises(Overruled):
                bench.drive(giver, known_epoch=unexplained)


    @pytest.mark.parametrize(('then', 'is_new'), [('Stopping', True), ('status Going to 9', False)])
    def test_of_a_drive_of_others_nobody_drives_either_before_the_robot_tells_why(
            self, bench, then, is_new):
        bench.status('Stopped')
        bench.robot('Going to 9', 'Interrupted: Going to 9')
        known = bench.epoch
        assert bench.dispatcher.in_doubt, 'a status would help'
        with pytest.raises(Unclear, match='why it broke off its drive'):
            bench.drive(OTHER, known_epoch=known)
        if then.startswith('status'):
            bench.status(then[len('status '):])
        else:
            bench.robot(then)
        assert (bench.epoch != known) is is_new
        with pytest.raises(Overruled) if is_new else nullcontext():
            bench.drive(OTHER, known_epoch=known)


class TestTwoGivers:
    def test_a_drive_that_was_interrupted_before_a_refused_one_was_ended_by_another_client(
            self, bench):
        """The robot stands, so the giver of the drive must not drive on in the old epoch."""
        drive = bench.drive(ROUTE)
        bench.robot('Going to 12')
        known = bench.epoch
        other = bench.drive(OTHER, 'goto 99')
        bench.robot('Interrupted: Going to 12')
        assert outcome(drive) is Outcome.INTERRUPTED
        assert bench.epoch == known, 'the newer drive may have replaced it'
        bench.robot('CommandError: goto 99', 'CommandErrorDescription: No goal')
        assert outcome(other) is Outcome.NO_GOAL
        assert bench.memory.cause is MotionCause.OTHER_CLIENT
        with pytest.raises(Overruled, match='"goto 12" of /bridge was interrupted'):
            bench.drive(ROUTE, known_epoch=known)

    def test_a_refused_command_takes_the_robot_from_nobody(self, bench):
        """Once, a refused command ended the route, and the robot drove on without a giver."""
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        before = bench.memory
        typo = bench.drive(PERSON, 'executeMacro Typo')
        bench.robot('CommandError: executeMacro Typo', "CommandErrorDescription: No macro 'Typo'")
        assert outcome(typo) is Outcome.REJECTED
        assert bench.memory == before
        bench.drive(ROUTE, 'goto 14', known_epoch=before.epoch)

    def test_nobody_passes_a_drive_that_the_robot_has_not_answered(self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.drive(PERSON, 'goto 3')
        with pytest.raises(Unclear):
            bench.drive(ROUTE, 'goto 14', known_epoch=bench.epoch)

    def test_the_drive_under_way_is_known_after_a_refused_newer_one(self, bench):
        """Once, a drive to a point counted as another client's after a newer drive was refused."""
        bench.drive(ROUTE, 'gotoPoint 1000 0 0')
        bench.robot('Going to point')
        known = bench.epoch
        bench.drive(PERSON, 'executeMacro Typo')
        bench.robot('CommandError: executeMacro Typo', "CommandErrorDescription: No macro 'Typo'")
        for _ in range(3):
            bench.status('Going to point', 1.0)
        assert (bench.epoch, bench.state, bench.memory.giver) == (
            known, MotionState.DRIVING, ROUTE)

    def test_the_last_drive_that_the_robot_obeys_names_the_giver(self, bench):
        """Two clients drive at the same time, and the robot obeys our drive last."""
        bench.drive(ROUTE)
        bench.robot('Going to 5')
        assert bench.memory.giver.name == ''
        bench.robot('Interrupted: Going to 5', 'Going to 12')
        assert (bench.memory.giver, bench.memory.goal) == (ROUTE, '12')

    def test_a_drive_of_unknown_fate_has_no_named_giver_until_the_robot_shows_it(self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.lose()
        assert bench.memory.giver.name == ''
        bench.connect()
        bench.status('Going to 12')
        assert bench.memory.giver == ROUTE


class TestWhoseStopping:
    """Once, the controller stopped its own drive after a `Stopping` that it could not explain."""

    @staticmethod
    def obeys(bench: Bench, *lines: str) -> None:
        drive = bench.drive(ROUTE, 'goto 14')
        known = bench.epoch
        bench.robot(*lines, 'Going to 14')
        assert bench.sent[-1] == 'goto 14', 'the drive was stopped'
        assert (bench.memory.giver, drive.result) == (ROUTE, None)
        assert bench.memory.cause is not MotionCause.OTHER_CLIENT, known

    @pytest.mark.parametrize('before', ['own', 'lost link', 'restart', 'another client'])
    def test_a_robot_that_replaces_a_drive_may_stop_for_an_instant(self, before):
        bench = Bench()
        bench.status('Stopped')
        if before != 'another client':
            bench.drive(ROUTE)
        bench.robot('Going to 12')
        if before == 'lost link':
            bench.lose()
            bench.connect()
        elif before == 'restart':
            bench = Bench(bench.kept[-1])
        bench.status('Going to 12')
        self.obeys(bench, 'Interrupted: Going to 12', 'Stopping')

    def test_a_stop_after_a_replacing_drive_gets_a_stopping_of_its_own(self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.drive(ROUTE, 'goto 14')
        bench.stop(PERSON)
        known = bench.epoch
        bench.robot('Interrupted: Going to 12', 'Stopping', 'Going to 14',
                    'Interrupted: Going to 14', 'Stopping', 'Stopped')
        assert (bench.epoch, bench.memory.giver, bench.memory.stop_owed) == (known, PERSON, False)

    @pytest.mark.parametrize('seconds', [0.0, 0.9, 5.0])
    def test_one_that_has_undocked_stops_once_more(self, bench, seconds):
        bench.status(DOCKED)
        bench.drive(ROUTE, 'undock')
        bench.robot('DockingState: Undocking ForcedState: Unforced ChargeState: Not', UNDOCKED)
        bench.pass_time(seconds)
        self.obeys(bench, 'Stopping', 'Stopped')

    def test_one_whose_fault_was_cleared_says_stopping(self, bench):
        bench.status('Stopped')
        bench.give('applicationFaultClear f', giver=ROUTE)
        bench.robot('FaultCleared: Fault_Driving_Application f "s" "l" true false true')
        self.obeys(bench, 'Stopping', 'ApplicationFaultClear cleared f')

    def test_one_whose_motors_were_enabled_stops(self, bench):
        bench.status('Motors disabled')
        bench.robot('Motors enabled')
        bench.pass_time(3.0)
        self.obeys(bench, 'Stopping', 'Stopped')

    def test_a_stop_of_ours_as_the_motors_come_on_gets_a_pair_of_its_own(self, bench):
        bench.stop(ROUTE)
        known = bench.epoch
        bench.robot('Motors enabled', 'Stopping', 'Stopped', 'Stopping', 'Stopped')
        assert bench.epoch == known

    @pytest.mark.parametrize('said, says_stopped', [
        (['Stopping', 'Motors enabled', 'Stopping'], 1),
        (['Motors enabled', 'Stopping', 'Stopping'], 2),
        (['Stopping', 'Motors enabled', 'Stopping'], 2)])
    def test_a_robot_that_begins_to_stop_twice_may_stand_once(self, bench, said, says_stopped):
        """Once, the stop ended only after 15 s, and as a failure."""
        bench.status('Motors disabled')
        stop = bench.stop(ROUTE)
        bench.robot(*said, 'Stopped')
        assert (outcome(stop), bench.memory.stop_owed) == (Outcome.SUCCEEDED, False)
        if says_stopped == 2:
            bench.robot('Stopped')
        known = bench.epoch
        bench.drive(ROUTE)
        bench.robot('Going to 12', 'Stopping')
        assert bench.epoch != known, 'the pair of the motors explains no other stop'

    @pytest.mark.parametrize('before', [
        [], ['Motors enabled', 'Stopping', 'Stopped'],
        ['FaultCleared: Fault_Driving_Application f "s" "l" true false true', 'Stopping']])
    def test_any_other_is_another_clients(self, bench, before):
        bench.status('Stopped')
        bench.robot(*before)
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.robot('Stopping')
        assert bench.memory.cause is MotionCause.OTHER_CLIENT

    def test_a_stop_of_a_robot_that_only_replaced_a_drive_is_another_clients(self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.pass_time(60.0)
        bench.drive(ROUTE, 'goto 14')
        bench.robot('Stopping', 'Stopped')
        assert bench.sent == ['goto 12', 'goto 14', 'stop'], 'the newer drive may still come'
        assert bench.memory.cause is MotionCause.OTHER_CLIENT


    def test_a_stopped_line_for_another_client_does_not_end_our_stop(self, bench):
        """The robot begins our drive only after the first `Stopped`, so our stop is still owed."""
        bench.status('Stopped')
        bench.drive(ROUTE)
        bench.robot('Stopping', 'Stopped', 'Going to 12')
        assert bench.sent == ['goto 12', 'stop']
        assert bench.memory.stop_owed
        bench.robot('Interrupted: Going to 12', 'Stopping', 'Stopped')
        assert not bench.memory.stop_owed

    def test_a_drive_between_stops_is_ours_although_an_older_stop_is_answered_late(self, bench):
        bench.status('Stopped')
        bench.stop(PERSON)
        bench.stop(PERSON)
        bench.drive(PERSON, 'goto 3')
        bench.stop(PERSON)
        known = bench.epoch
        bench.robot('Stopping', 'Stopped', 'Stopping', 'Stopped', 'Going to 3',
                    'Interrupted: Going to 3', 'Stopping', 'Stopped')
        assert (bench.epoch, bench.memory.giver) == (known, PERSON)

    @pytest.mark.parametrize('seconds, line', [
        (16.0, ''), (0.5, 'Unknown command stop'), (1.5, 'CommandError: stop')])
    def test_a_stop_that_the_robot_does_not_answer_explains_no_stopping(self, bench, seconds, line):
        bench.status('Stopped')
        bench.stop(PERSON)
        bench.robot(*[line] if line else [])
        bench.pass_time(seconds)
        bench.drive(PERSON, 'goto 3')
        last = bench.stop(PERSON)
        bench.robot('Stopping', 'Stopped')
        for _ in range(4):
            bench.status('Stopped', seconds=1.0)
        assert last.result.outcome is Outcome.SUCCEEDED
        bench.robot('Stopping')
        assert bench.memory.cause is MotionCause.OTHER_CLIENT

    @pytest.mark.parametrize('said', [['Stopping', 'Stopped'], ['Stopped']])
    def test_nor_do_stops_that_the_robot_answered_together(self, bench, said):
        """Once, a program drove on although another client had stopped the robot."""
        bench.status('Stopped')
        bench.stop(PERSON)
        bench.stop(ROUTE)
        bench.robot(*said)
        assert not bench.memory.stop_owed
        for _ in range(2):
            bench.give('oneLineStatus')
            bench.status('Stopped')
        known = bench.epoch
        bench.robot('Stopping', 'Stopped')
        with pytest.raises(Overruled):
            bench.drive(ROUTE, known_epoch=known)

    def test_a_stop_may_be_answered_after_the_next_status(self, bench):
        """Right after a command, the status may still be the old one."""
        bench.status('Going to 9')
        bench.give('oneLineStatus')
        stop = bench.stop(ROUTE)
        bench.give('arclStat')
        known = bench.epoch
        bench.status('Going to 9')
        bench.give('oneLineStatus')
        bench.status('Going to 9')
        bench.robot('Stopping', 'Stopped')
        assert (outcome(stop), bench.epoch) == (Outcome.SUCCEEDED, known)

    @pytest.mark.parametrize('interruption', [[], ['Interrupted: Going to 3']])
    def test_the_pair_of_another_client_does_not_end_our_stop_behind_an_unanswered_drive(
            self, bench, interruption):
        bench.status('Stopped')
        bench.drive(ROUTE, 'goto 3')
        stop = bench.stop(ROUTE)
        bench.robot('Stopping', 'Stopped')
        assert (stop.result, bench.memory.stop_owed) == (None, True)
        bench.drive(ROUTE, 'goto 3')
        bench.robot('Going to 3', *interruption, 'Stopping', 'Stopped', 'Going to 3')
        assert (bench.memory.giver, bench.memory.stop_owed) == (ROUTE, False)
        bench.records.all_cancelled(PERSON)
        bench.pass_time(1.0)
        assert bench.sent == ['goto 3', 'stop', 'goto 3', 'stop']

    def test_after_that_pair_our_stop_is_owed_through_an_outage(self, bench):
        bench.status('Stopped')
        bench.drive(ROUTE, 'goto 3')
        bench.stop(ROUTE)
        bench.robot('Stopping', 'Stopped')
        bench.lose()
        bench.connect()
        bench.status('Going to 3')
        bench.pass_time(2 * RETRY)
        assert bench.sent == ['goto 3', 'stop', 'stop']

    @pytest.mark.parametrize('shown, command, line', [
        (DOCKED, 'goto 3', UNDOCKING), ('Stopped', 'dock', 'Going to Dock1')])
    def test_a_stop_behind_a_drive_of_which_the_robot_said_anything_ends_with_its_pair(
            self, bench, shown, command, line):
        bench.status(shown)
        bench.drive(ROUTE, command)
        bench.robot(line)
        stop = bench.stop(ROUTE)
        bench.robot('Stopping', 'Stopped')
        assert outcome(stop) is Outcome.SUCCEEDED

    def test_the_pair_of_the_motors_is_none_of_a_stop_behind_an_unanswered_drive(self, bench):
        bench.status('Motors disabled')
        for text in ('goto 3', 'stop', 'stop'):
            last = bench.give(text, giver=PERSON)
        known = bench.epoch
        bench.robot('Motors enabled', 'Stopping', 'Stopped')
        assert last.result is None
        bench.robot('Going to 3', 'Interrupted: Going to 3', 'Stopping', 'Stopped', 'Stopping',
                    'Stopped')
        assert (bench.epoch, bench.memory.giver, bench.memory.stop_owed) == (known, PERSON, False)

    def test_a_drive_that_an_emergency_stop_ended_is_answered_before_a_newer_one_to_its_goal(
            self, bench):
        """Once, the newer drive counted as broken off, and the published cause was another client.
        """
        bench.status('Stopped')
        bench.drive(PERSON, 'goto 3')
        bench.robot('EStop pressed')  # sent before `goto 3` reached the robot
        newer = bench.drive(PERSON, 'goto 3')
        assert bench.sent == ['goto 3', 'stop', 'goto 3']
        bench.robot('EStop relieved but motors still disabled', 'Motors enabled', 'Stopping',
                    'Stopped', 'Going to 3', 'Interrupted: Going to 3', 'Stopping', 'Stopped')
        assert (newer.result, bench.memory.stop_owed) == (None, False)
        bench.robot('Going to 3')
        assert (bench.memory.giver, bench.memory.ruling.fate) == (PERSON, Fate.OBEYED)
        bench.robot('Arrived at 3')
        assert outcome(newer) is Outcome.SUCCEEDED
        assert bench.sent == ['goto 3', 'stop', 'goto 3']

    def test_nor_is_a_stop_behind_it_ended_by_the_answer_to_an_older_stop(self, bench):
        """Once, the newer drive ended as interrupted while the robot carried it out."""
        bench.status('Stopped')
        bench.stop(ROUTE)
        bench.drive(PERSON, 'goto 4')
        bench.robot('EStop pressed')  # sent before `stop` reached the robot
        newer = bench.drive(PERSON, 'goto 4')
        assert bench.sent == ['stop', 'goto 4', 'stop', 'goto 4']
        bench.robot('EStop relieved but motors still disabled', 'Motors enabled',
                    'Stopping', 'Stopped')
        assert bench.memory.stop_owed
        bench.robot('Going to 4', 'Interrupted: Going to 4', 'Stopping', 'Stopped', 'Going to 4')
        assert (newer.result, bench.memory.giver) == (None, PERSON)

    def test_a_second_emergency_stop_forgets_no_drive_that_is_on_its_way(self, bench):
        bench.status('Stopped')
        bench.drive(PERSON, 'goto 4')
        bench.robot('EStop pressed', 'Motors enabled', 'EStop pressed', 'Motors enabled')
        assert bench.sent == ['goto 4', 'stop'], 'one stop ends it'
        bench.robot('Going to 4', 'Stopping', 'Stopped')
        assert (bench.memory.cause, bench.memory.stop_owed) == (
            MotionCause.EMERGENCY_STOP, False)

    def test_a_late_refusal_of_it_is_none_of_the_newer_drive(self, bench):
        bench.status('Stopped')
        bench.drive(ROUTE, 'goto 4')
        bench.robot('EStop pressed')
        newer = bench.drive(PERSON, 'goto 4')
        bench.robot('CommandError: goto 4', 'CommandErrorDescription: EStop pressed',
                    'Motors enabled', 'Stopping', 'Stopped', 'Going to 4')
        assert (newer.result, bench.memory.giver) == (None, PERSON)

    def test_the_pair_of_the_motors_is_none_of_a_stop_behind_a_drive_that_timed_out(self, bench):
        bench.status('Motors disabled')
        bench.drive(PERSON, 'goto 3')
        bench.pass_time(61.0)
        stop = bench.stop(PERSON)
        bench.robot('Motors enabled', 'Stopping', 'Stopped')
        assert stop.result is None
        bench.robot('Going to 3', 'Stopping', 'Stopped')
        assert outcome(stop) is Outcome.SUCCEEDED
        assert bench.memory.cause is MotionCause.STOP

    def test_so_is_one_between_two_stops_before_and_two_after(self, bench):
        bench.status('Stopped')
        commands = [bench.give(text, giver=PERSON)
                    for text in ('stop', 'stop', 'goto 3', 'stop', 'stop')]
        known = bench.epoch
        bench.robot('Stopping', 'Stopped', 'Stopping', 'Stopped')
        assert [command.result is None for command in commands] == [False, False, True, True, True]
        bench.robot('Going to 3', 'Interrupted: Going to 3', 'Stopping', 'Stopped', 'Stopping',
                    'Stopped')
        assert (bench.epoch, bench.memory.giver, bench.memory.stop_owed) == (known, PERSON, False)


class TestLinesWithoutAName:
    @pytest.mark.parametrize('line', ['Unknown command', 'SetUpError: start a list first'])
    def test_one_does_not_end_the_drive_under_way(self, bench, line):
        """A robot without oneLineStatus answers each heartbeat with such a line. Once, this line
        ended every goto.
        """
        drive = bench.drive(ROUTE)
        bench.robot('Going to 12')
        query = bench.give('arclStat')
        bench.robot(line)
        assert (drive.result, query.result is None) == (None, False)

    @pytest.mark.parametrize('line', ['Unknown command', 'SetUpError: start a list first'])
    def test_nor_one_that_leaves_the_dock(self, bench, line):
        """The robot leaves its dock for a drive before it acknowledges the drive."""
        bench.status(DOCKED)
        drive = bench.drive(ROUTE)
        bench.robot('DockingState: Undocking ForcedState: Unforced ChargeState: Float')
        other = bench.give('listAdd say hello')
        bench.robot(line)
        assert (drive.result, other.result is None) == (None, False)
        bench.robot(UNDOCKED, 'Going to 12')
        assert bench.memory.giver == ROUTE

    def test_one_ends_a_query_rather_than_a_drive_that_the_robot_may_carry_out(self, bench):
        query = bench.give('arclStat')
        drive = bench.drive(ROUTE)
        bench.robot('Unknown command')
        assert (drive.result, outcome(query)) == (None, Outcome.UNKNOWN_COMMAND)
        bench.robot('Unknown command')
        assert outcome(drive) is Outcome.UNKNOWN_COMMAND


class TestOtherMotions:
    @pytest.mark.parametrize('command', [
        'follow', 'go', 'pauseTaskCancel', 'localizeToPoint 1 2 3', 'localizeAtGoal 1',
        'doTaskInstant x', 'enableMotors', 'queueDropoff 12', 'applicationBlockDrivingClear x'])
    def test_whatever_moves_the_robot_does_not_pass_a_stop(self, bench, command):
        """Not only drives, but all commands that may move the robot carry an epoch."""
        known = bench.epoch
        bench.stop(PERSON)
        with pytest.raises(Overruled):
            bench.give(command, giver=ROUTE, known_epoch=known)

    def test_another_clients_drive_during_our_docking_is_told_at_once(self, bench):
        """Once, such a drive was published only after 30 s."""
        bench.status('Stopped')
        dock = bench.drive(ROUTE, 'dock')
        bench.robot(DOCKING)
        known = bench.epoch
        bench.robot('Going to 5')
        assert (bench.epoch != known, outcome(dock)) == (True, Outcome.INTERRUPTED)

    @pytest.mark.parametrize('line', ['Going to DockLynx', 'Going to dock at Dock1'])
    def test_a_robot_may_drive_to_its_dock_by_name(self, bench, line):
        dock = bench.drive(ROUTE, 'dock')
        bench.robot(line, DOCKING, line, DOCKED)
        assert outcome(dock) is Outcome.SUCCEEDED
        assert bench.memory.giver == ROUTE


class TestDrivesOnTheirWay:
    """A drive that the robot has not answered may still begin."""

    def test_a_stop_that_ends_one_of_another_giver_does_not_know_of_it(self, bench):
        """Otherwise the giver of the stop would drive without knowledge of the other drive."""
        bench.status('Stopped')
        known = bench.epoch
        bench.drive(ROUTE)
        bench.stop(OTHER, known_epoch=known)
        bench.robot('Going to 12', 'Interrupted: Going to 12', 'Stopping', 'Stopped')
        with pytest.raises(Overruled):
            bench.drive(OTHER, 'goto 9', known_epoch=known)
        bench.stop(OTHER, known_epoch=known)
        bench.drive(OTHER, 'goto 9', known_epoch=bench.epoch)

    def test_one_that_crosses_an_emergency_stop_is_stopped(self, bench):
        """The drive may begin when the motors are on again. Then it would have no giver."""
        bench.status('Stopped')
        drive = bench.drive(ROUTE)
        bench.robot('EStop pressed')
        assert outcome(drive) is Outcome.EMERGENCY_STOPPED
        assert (bench.memory.stop_owed, bench.sent) == (True, ['goto 12', 'stop'])

    def test_one_that_the_robot_refuses_in_an_emergency_stop_needs_no_stop(self, bench):
        bench.robot('EStop pressed')
        drive = bench.drive(ROUTE)
        bench.robot('CommandError: goto 12',
                    'CommandErrorDescription: Cannot drive, EStop pressed')
        assert outcome(drive) is Outcome.EMERGENCY_STOPPED
        assert not bench.memory.stop_owed
        assert not bench.memory.drives, 'a refused command is no drive'


class TestManyDrives:
    def test_a_drive_is_refused_while_the_robot_has_many_to_answer(self, bench):
        bench.status('Stopped')
        drives = [bench.drive(PERSON, f'goto {n}') for n in range(MOST_OPEN)]
        with pytest.raises(Busy, match=f'{MOST_OPEN} drives before it.*"stop"') as refused:
            bench.drive(PERSON, 'goto 99')
        assert refused.value.limit == MOST_OPEN
        assert 'goto 99' not in bench.sent
        bench.robot('Going to 0', 'Going to 1')
        assert outcome(drives[0]) is Outcome.INTERRUPTED
        assert (bench.has_begun(drives[1]), bench.memory.giver) == (True, PERSON)
        bench.drive(PERSON, 'goto 99')

    def test_also_if_their_commands_have_ended_until_the_robot_obeys_the_stop(self, bench):
        bench.status('Stopped')
        for n in range(MOST_OPEN):
            bench.drive(PERSON, f'goto {n}')
        bench.robot('EStop pressed')
        with pytest.raises(Busy):
            bench.drive(PERSON, 'goto 99')
        bench.robot('Motors enabled', 'Stopping', 'Stopped')
        for _ in range(3):
            bench.status('Stopped', 1.5)
        bench.drive(PERSON, 'goto 99')

    def test_a_stop_is_not_refused_and_no_number_of_stops_makes_the_robot_forget_a_drive(
            self, bench):
        bench.status('Stopped')
        drive = bench.drive(PERSON, 'goto 3')
        stops = [bench.stop(OTHER) for _ in range(5 * MOST_OPEN)]
        assert len(bench.memory.records) <= 3 * MOST_OPEN
        assert [r.goal for r in bench.memory.records if r.pending] == ['3']
        bench.robot('Going to 3')
        assert (bench.has_begun(drive), bench.memory.stop_owed) == (True, True)
        bench.robot('Stopping', 'Stopped')
        assert {outcome(stop) for stop in stops} == {Outcome.SUCCEEDED}
        assert not bench.memory.stop_owed

    def test_the_stop_before_many_drives_is_owed_until_the_robot_obeys_one_of_them(self, bench):
        bench.status('Stopped')
        bench.stop(OTHER)
        for n in range(MOST_OPEN):
            bench.drive(PERSON, f'goto {n}')
        assert bench.memory.stop_owed
        bench.robot('Stopping', 'Stopped', 'Going to 0')
        assert (bench.memory.stop_owed, bench.memory.giver) == (False, PERSON)


class TestLastCommands:
    """A giver that lost an answer can read the fate of its last command."""

    @staticmethod
    def told(bench: Bench, giver: Giver = ROUTE) -> Tuple[int, Optional[CommandFate]]:
        return next(((last.number, last.fate) for last in bench.memory.last_commands
                     if last.giver == giver.name), (0, None))

    @pytest.mark.parametrize('lines, fate', [
        ([], CommandFate.GIVEN), (['Going to 12'], CommandFate.OBEYED),
        (['Going to 12', 'Arrived at 12'], CommandFate.COMPLETED),
        (['Going to 12', 'Error: Failed going to goal', 'Failed going to goal'],
         CommandFate.FAILED),
        (['CommandError: goto 12', "CommandErrorDescription: No goal '12'"],
         CommandFate.NOT_OBEYED),
        (['Going to 12', 'Interrupted: Going to 12', 'Going to 9'], CommandFate.NOT_OBEYED)])
    def test_the_lines_of_the_robot_decide(self, bench, lines, fate):
        bench.drive(ROUTE, number=7)
        bench.robot(*lines)
        assert self.told(bench) == (7, fate)

    @pytest.mark.parametrize('shown, fate', [
        ('Going to 12', CommandFate.OBEYED), ('Arrived at 12', CommandFate.COMPLETED),
        ('Stopped', CommandFate.NOT_OBEYED), ('Going to 9', CommandFate.NOT_OBEYED)])
    @pytest.mark.parametrize('outage', ['link', 'restart'])
    def test_after_an_outage_the_first_status_decides(self, bench, shown, fate, outage):
        bench.drive(ROUTE, number=7)
        if outage == 'link':
            bench.lose()
            bench.connect()
        else:
            bench = Bench(bench.kept[-1])
        assert self.told(bench) == (7, CommandFate.UNKNOWN)
        bench.status(shown)
        assert self.told(bench) == (7, fate)

    def test_a_drive_that_did_not_reach_the_robot_is_not_obeyed_in_the_same_epoch(self, bench):
        bench.drive(ROUTE, 'goto 9', number=6)
        bench.robot('Going to 9', 'Arrived at 9')
        bench.drive(ROUTE, number=7)
        known = bench.epoch
        bench.lose()
        bench.connect()
        bench.status('Arrived at 9')
        assert (self.told(bench), bench.epoch) == ((7, CommandFate.NOT_OBEYED), known)

    def test_the_end_of_a_lost_drive_is_told_when_the_status_shows_it(self, bench):
        bench.drive(ROUTE, number=7)
        bench.lose()
        bench.connect()
        bench.status('Going to 12')
        bench.status('Arrived at 12')
        assert self.told(bench) == (7, CommandFate.COMPLETED)

    def test_a_stop_is_told_until_the_robot_stands(self, bench):
        bench.stop(ROUTE, number=7)
        assert self.told(bench) == (7, CommandFate.GIVEN)
        bench.robot('Stopping', 'Stopped')
        assert self.told(bench) == (7, CommandFate.COMPLETED)

    def test_a_stop_without_a_link_is_with_the_controller(self):
        bench = Bench(is_linked=False)
        bench.dispatcher.start_without_link(parse_command('stop'), ROUTE, 0, 7)
        assert self.told(bench) == (7, CommandFate.GIVEN)

    @pytest.mark.parametrize('other', [
        lambda bench: bench.stop(OTHER, number=3), lambda bench: bench.stop(PERSON),
        lambda bench: bench.records.all_cancelled(PERSON)])
    @pytest.mark.parametrize('is_linked', [True, False])
    def test_a_stop_that_another_one_stands_for_is_told_until_the_robot_stands(
            self, other, is_linked):
        bench = Bench()
        bench.drive(PERSON, 'goto 3')
        bench.robot('Going to 3')
        if is_linked:
            bench.stop(ROUTE, number=7)
            bench.robot('Unknown command stop')  # so the stop is owed, and not under way
        else:
            bench.lose()
            bench.dispatcher.start_without_link(parse_command('stop'), ROUTE, 0, 7)
            bench.connect()
        other(bench)
        assert self.told(bench) == (7, CommandFate.GIVEN)
        assert self.told(Bench(bench.kept[-1])) == (7, CommandFate.UNKNOWN)
        bench.status('Going to 3')
        bench.pass_time(LOOK)
        bench.robot('Stopping', 'Stopped')
        assert self.told(bench) == (7, CommandFate.COMPLETED)
        bench.drive(PERSON, 'goto 4')
        bench.robot('Going to 4')
        assert self.told(bench) == (7, CommandFate.COMPLETED)

    def test_a_robot_that_stands_obeys_all_stops_before_that_one(self, bench):
        bench.drive(PERSON, 'goto 3')
        bench.robot('Going to 3')
        bench.stop(ROUTE, number=7)
        bench.stop(OTHER, number=3)
        for _ in range(3):
            bench.status('Stopped', 1.0)
        assert self.told(bench, OTHER) == (3, CommandFate.COMPLETED)
        assert self.told(bench) == (7, CommandFate.COMPLETED)

    @pytest.mark.parametrize('lines, end, fate', [
        (['Stopping', 'Stopped'], Outcome.SUCCEEDED, CommandFate.COMPLETED),
        (['Unknown command stop'], Outcome.UNKNOWN_COMMAND, CommandFate.NOT_OBEYED)])
    def test_a_stop_that_another_client_crosses_is_told_until_its_command_ends(
            self, bench, lines, end, fate):
        bench.status('Stopped')
        stop = bench.stop(ROUTE, number=7)
        bench.robot('Going to 9')
        assert (self.told(bench), bench.memory.cause) == (
            (7, CommandFate.GIVEN), MotionCause.OTHER_CLIENT)
        bench.robot(*lines)
        assert (outcome(stop), self.told(bench)) == (end, (7, fate))

    def test_a_stop_that_another_one_stands_for_is_not_obeyed_if_a_drive_replaces_both(self, bench):
        bench.stop(ROUTE, number=7)
        bench.robot('Unknown command stop')
        bench.stop(OTHER, number=3)
        bench.drive(PERSON, 'goto 4')
        bench.robot('Going to 4')
        assert self.told(bench) == (7, CommandFate.NOT_OBEYED)

    def test_of_any_number_of_givers_that_stop_the_robot_a_bounded_number_is_kept(self, bench):
        bench.lose()
        for process in range(50):
            bench.dispatcher.start_without_link(
                parse_command('stop'), Giver(f'/program_{process}'), 0, 1)
        assert len(bench.memory.records) == 1
        assert len(bench.memory.records[0].stands_for) == 20
        assert len(bench.memory.last_commands) <= 22

    @pytest.mark.parametrize('last', ['goto 9', 'stop'])
    def test_a_drive_that_comes_after_a_newer_command_of_its_giver_is_refused(self, bench, last):
        bench.give(last, giver=ROUTE, number=8)
        for number in (7, 8):
            with pytest.raises(Overruled):
                bench.drive(ROUTE, number=number, known_epoch=bench.epoch)
        bench.drive(PERSON, 'goto 12', number=1)

    def test_one_that_another_command_came_before_is_not_obeyed(self, bench):
        known = bench.epoch
        bench.drive(ROUTE, number=1, known_epoch=known)
        bench.robot('Going to 12')
        bench.stop(PERSON)
        for number in (3, 2):  # the second one is late
            with pytest.raises(Overruled):
                bench.drive(ROUTE, 'goto 14', number=number, known_epoch=known)
            assert self.told(bench) == (3, CommandFate.NOT_OBEYED)
            assert bench.kept[-1].last_commands == bench.memory.last_commands

    def test_a_stop_is_never_late(self, bench):
        bench.drive(ROUTE, number=8)
        bench.stop(ROUTE, number=7)
        assert bench.sent == ['goto 12', 'stop']

    def test_commands_without_a_number_are_not_told(self, bench):
        bench.drive(ROUTE)
        assert bench.memory.last_commands == ()

    def test_a_bounded_number_of_givers_is_told(self, bench):
        for process in range(50):
            bench.drive(Giver(f'/program_{process}'), number=1)
            bench.robot('Going to 12')
        assert len(bench.memory.last_commands) == 20
        assert self.told(bench, Giver('/program_49'))[0] == 1

    def test_no_number_of_givers_hides_one_that_the_robot_has_to_answer(self, bench):
        bench.drive(ROUTE, 'goto 3', number=1)
        for process in range(50):
            bench.stop(Giver(f'/program_{process}'), number=1)
        assert self.told(bench) == (1, CommandFate.GIVEN)


class TestState:
    def test_it_follows_the_lines(self, bench):
        """Once, the state followed the heartbeat, so that it came up to 1.5 s late."""
        bench.status('Stopped')
        for line, state in (('Going to 9', MotionState.DRIVING), ('Stopping', MotionState.STOPPING),
                            ('Stopped', MotionState.STANDING), (DOCKING, MotionState.DOCKING),
                            (DOCKED, MotionState.DOCKED)):
            bench.robot(line)
            assert bench.state is state, line

    def test_a_drive_that_another_client_ended_does_not_seem_to_go_on(self, bench):
        bench.drive(ROUTE)
        bench.robot('Going to 12', 'Going to 9', 'Arrived at 9')
        bench.status('Arrived at 9')
        assert bench.state is MotionState.STANDING

    def test_an_answer_about_the_dock_does_not_say_that_the_robot_stands(self, bench):
        bench.robot('Going to 9')
        bench.give('queryDockStatus')
        bench.robot(UNDOCKED)
        assert bench.state is MotionState.DRIVING

    def test_it_is_what_the_robot_does(self, bench):
        assert bench.state is MotionState.UNKNOWN, 'no line has come from the robot'
        for shown, state in (('Stopped', MotionState.STANDING),
                             ('Teleop driving', MotionState.MANUAL),
                             ('Going to 9', MotionState.DRIVING),
                             (DOCKING, MotionState.DOCKING)):
            bench.status(shown)
            assert bench.state is state, shown
        bench.lose()
        assert bench.state is MotionState.UNKNOWN

    def test_a_robot_is_not_known_to_stand_while_a_command_is_under_way(self, bench):
        bench.status('Stopped')
        bench.drive(ROUTE)
        assert bench.state is MotionState.DRIVING
        bench.stop(ROUTE)
        assert bench.state is MotionState.STOPPING


class TestEmergencyStop:
    @pytest.mark.parametrize('lines, told', [
        (['EStop pressed'], True), (['Status: EStop pressed'], True),
        (['EStop pressed', 'EStop relieved but motors still disabled'], True),
        (['EStop pressed', 'Status: Motors disabled'], True),
        (['EStop pressed', 'Motors enabled'], False), (['EStop pressed', 'Status: Stopped'], False),
        (['Motors disabled', 'Status: Motors disabled'], False)])
    def test_it_lasts_until_the_robot_can_drive(self, bench, lines, told):
        bench.status('Stopped')
        bench.robot(*lines)
        assert bench.records.motion.emergency_stop is told

    @pytest.mark.parametrize('line, told', [
        ('Status: EStop pressed', True), ('Status: Stopped', False), ('Going to 9', False)])
    def test_without_a_link_the_last_one_stays_until_the_robot_says_what_it_does(
            self, bench, line, told):
        bench.robot('EStop pressed')
        for _ in range(2):
            bench.lose()
            assert (bench.records.motion.emergency_stop, bench.state) == (True, MotionState.UNKNOWN)
            bench.connect()
        known = bench.epoch
        assert (bench.records.motion.emergency_stop, bench.state) == (True, MotionState.UNKNOWN)
        bench.robot(line)
        assert bench.records.motion.emergency_stop is told
        assert bench.epoch != known, 'somebody may have driven it meanwhile'

    def test_a_controller_that_starts_does_not_know_of_it(self, bench):
        bench.robot('EStop pressed')
        motion = Bench(bench.memory).records.motion
        assert (motion.emergency_stop, motion.state) == (False, MotionState.UNKNOWN)
