"""Another client drives or stops the robot: to no named goal, in an outage, or before our drive.

The other client's drive is never published as one of ours. No program drives the robot without
knowledge of the other client's drive or stop.
"""
from __future__ import annotations

import pytest
from arcl_builders import outcome
from drive_bench import DOCKED, DOCKING, PERSON, ROUTE, UNDOCKED, UNDOCKING, Bench

from omron_arcl import Outcome, parse_command
from omron_arcl.drives import LOOK, Overruled
from omron_arcl.execution import NO_GIVER
from omron_arcl.records import CommandFate, MotionCause, RecordKind

CLEARED = 'FaultCleared: Fault_Driving_Application f "s" "l" {} false true'
ELSEWHERE = ['Going to point', 'Going to 100 200', 'Patrolling route r', 'Doing task wait 5',
             'Executing macro m']


@pytest.fixture
def bench() -> Bench:
    bench = Bench()
    bench.status('Stopped')
    return bench


def driving(bench: Bench, text: str = 'goto 12', line: str = 'Going to 12') -> int:
    """Lets the robot carry out a drive of ours. Returns the epoch."""
    bench.drive(ROUTE, text)
    bench.robot(line)
    return bench.epoch


def after_outage(bench: Bench, how: str = 'lost link') -> Bench:
    """Returns the bench after an outage."""
    if how == 'restart':
        return Bench(bench.kept[-1])
    bench.lose()
    bench.connect()
    return bench


def test_a_drive_that_nobody_here_gave_is_told_so_whatever_its_name(bench):
    for line in ELSEWHERE:
        known = driving(bench)
        bench.robot(line)
        assert (bench.epoch != known, bench.memory.ruling.kind) == (
            True, RecordKind.FOREIGN_DRIVE), line


class TestAMotionWithoutAName:
    """Once, a person used another client to send the robot to a point. The fleet drove it on."""

    @pytest.mark.parametrize('how', ['lost link', 'restart'])
    @pytest.mark.parametrize('shown', [*ELSEWHERE, 'Parking', UNDOCKING])
    def test_is_not_that_of_our_drive_to_a_goal_after_an_outage(self, bench, how, shown):
        driving(bench)
        bench = after_outage(bench, how)
        known = bench.epoch
        bench.status(shown)
        assert (bench.epoch != known, bench.memory.giver) == (True, NO_GIVER)

    @pytest.mark.parametrize('line', ELSEWHERE)
    def test_nor_if_the_robot_begins_it_later(self, bench, line):
        driving(bench)
        after_outage(bench)
        bench.status('Going to 12')
        known = bench.epoch
        bench.robot('Interrupted: Going to 12', line)
        assert (bench.epoch != known, bench.memory.giver) == (True, NO_GIVER)

    @pytest.mark.parametrize('shown', [*ELSEWHERE, 'Parking'])
    def test_nor_if_only_statuses_show_it(self, bench, shown):
        driving(bench)
        after_outage(bench)
        bench.status('Going to 12')
        known = bench.epoch
        for _ in range(2):
            bench.status(shown, 1.0)
        assert (bench.epoch != known, bench.memory.giver) == (True, NO_GIVER)

    @pytest.mark.parametrize('shown', ['Going to 9', 'Going to point'])
    def test_that_others_break_off_begins_another_epoch_also_if_only_statuses_show_it(
            self, bench, shown):
        for _ in range(3):
            bench.status(shown, 1.0)
        known = bench.epoch
        bench.status('Stopped', 1.0)
        assert bench.epoch != known

    @pytest.mark.parametrize('text, line, shown', [
        ('gotoPoint 1 2', 'Going to point', 'Going to point'),
        ('doTask wait 5', 'Doing task wait 5', 'Going to 3'),
        ('patrol r', 'Patrolling route r', 'Patrolling route r'),
        ('executeMacro m', 'Executing macro m', 'Executing macro m'),
        ('dock', DOCKING, 'Going to Dock1'), ('dock', DOCKING, UNDOCKING)])
    def test_may_be_that_of_a_drive_without_one(self, bench, text, line, shown):
        known = driving(bench, text, line)
        after_outage(bench)
        for _ in range(3):
            bench.status(shown, 1.0)
        assert (bench.epoch, bench.memory.giver) == (known, ROUTE)

    def test_is_that_of_the_drive_without_one_not_of_a_newer_one_with_a_name(self, bench):
        bench.drive(ROUTE, 'gotoPoint 1 2')
        bench.drive(PERSON, 'goto 12')
        after_outage(bench)
        bench.status('Going to point')
        assert bench.memory.giver == ROUTE

    @pytest.mark.parametrize('text, line, shown', [
        ('gotoPoint 1 2', 'Going to point', 'Going to 7'), ('undock', UNDOCKING, 'Going to point'),
        ('gotoPoint 1 2', 'Going to point', 'Patrolling route r')])
    def test_of_another_kind_is_not_that_of_a_drive_without_one(self, bench, text, line, shown):
        driving(bench, text, line)
        after_outage(bench)
        known = bench.epoch
        bench.status(shown)
        assert (bench.epoch != known, bench.memory.giver) == (True, NO_GIVER)

    def test_a_robot_that_leaves_its_dock_may_do_so_for_a_drive_that_was_on_its_way(self, bench):
        bench.status(DOCKED)
        bench.drive(ROUTE)
        bench.robot(UNDOCKING)
        after_outage(bench)
        for _ in range(3):
            bench.status(UNDOCKING, 1.0)
        bench.robot(UNDOCKED, 'Going to 12')
        assert bench.memory.giver == ROUTE


class TestADriveToAGoalOfOurs:
    @pytest.mark.parametrize('end', ['Arrived at 12', 'Error: Failed going to goal'])
    def test_is_another_clients_once_ours_has_ended(self, bench, end):
        driving(bench)
        bench.robot(end)
        known = bench.epoch
        bench.robot('Going to 12')
        assert (bench.epoch != known, bench.memory.giver) == (True, NO_GIVER)

    def test_that_fails_after_an_outage_was_ended_by_the_robot(self, bench):
        driving(bench)
        after_outage(bench)
        bench.status('Going to 12')
        for _ in range(2):
            bench.status('Failed going to 12', 1.0)
        assert bench.memory.cause is MotionCause.ROBOT


class TestADriveThatGoesOn:
    """The giver may have given up the drive. So the giver must learn that the drive goes on."""

    def test_although_the_drive_that_was_to_replace_it_was_lost_with_the_link(self, bench):
        driving(bench)
        bench.drive(PERSON, 'goto 3')
        after_outage(bench)
        known = bench.epoch
        bench.status('Going to 12')
        assert (bench.epoch != known, bench.memory.giver, bench.memory.cause) == (
            True, ROUTE, MotionCause.OTHER_GIVER)

    def test_although_a_person_gave_a_wrong_goal_before_the_first_status(self, bench):
        driving(bench)
        after_outage(bench)
        bench.drive(PERSON, 'goto 99')
        known = bench.epoch
        bench.robot('CommandError: goto 99', "CommandErrorDescription: No goal '99'")
        bench.status('Going to 12')
        assert (bench.epoch != known, bench.memory.giver, bench.memory.cause) == (
            True, ROUTE, MotionCause.OTHER_GIVER)


class TestAFailure:
    @pytest.mark.parametrize('line', ['Error: Failed going to goal', 'Failed going to goal',
                                      'Error: Stalled', 'Cannot find path'])
    def test_while_another_client_drives_is_not_one_of_our_drive_to_come(self, bench, line):
        """Once, the drive counted as failed, and the robot drove on without a giver."""
        bench.robot('Going to 5')
        drive = bench.drive(ROUTE)
        bench.robot(line, 'Going to 12')
        assert (drive.result, bench.memory.giver) == (None, ROUTE)

    @pytest.mark.parametrize('lines', [
        ['Error: Failed to play file'], ['Motors disabled', 'Motors enabled']])
    def test_of_something_else_does_not_end_a_drive_that_is_on_its_way(self, bench, lines):
        drive = bench.drive(ROUTE)
        bench.robot(*lines, 'Going to 12')
        assert (drive.result, bench.memory.giver) == (None, ROUTE)

    def test_is_one_of_our_drive_once_the_robot_has_broken_off_the_other(self, bench):
        bench.robot('Going to 5')
        drive = bench.drive(ROUTE)
        bench.robot('Interrupted: Going to 5', 'Error: Failed going to goal')
        assert outcome(drive) is Outcome.FAILED


class TestWhatDoesNotExplainAStop:
    """If the robot has no reason of its own to say `Stopping`, another client has stopped it."""

    @pytest.mark.parametrize('command, lines', [
        ('queryMotors', ['Motors enabled']), ('enableMotors', ['Motors are enabled']),
        ('applicationFaultClear f', [CLEARED.format('false'), 'ApplicationFaultClear cleared f']),
        ('applicationFaultClear f', [CLEARED.format('true')])])
    def test_motors_that_were_on_and_a_fault(self, bench, command, lines):
        bench.give(command, giver=ROUTE)
        bench.robot(*lines)
        known = bench.epoch
        bench.robot('Stopping', 'Stopped')
        assert bench.epoch != known

    def test_a_cleared_fault_explains_one_stopping_beside_that_of_our_stop(self, bench):
        stop = bench.stop(ROUTE)
        known = bench.epoch
        bench.robot(CLEARED.format('true'), 'Stopping', 'Stopping', 'Stopped')
        assert (outcome(stop), bench.epoch) == (Outcome.SUCCEEDED, known)

    @pytest.mark.parametrize('command', ['dock', 'undock'])
    def test_a_command_about_the_dock_that_the_robot_has_not_read(self, bench, command):
        driving(bench)
        bench.drive(ROUTE, command)
        known = bench.epoch
        bench.robot('Interrupted: Going to 12', 'Stopping', 'Stopped')
        assert (bench.epoch != known, bench.sent[-1]) == (True, 'stop')

    @pytest.mark.parametrize('interrupted', [['Interrupted: Going to Dock1'], []])
    def test_the_way_to_the_dock(self, bench, interrupted):
        dock = bench.drive(ROUTE, 'dock')
        bench.robot('Going to Dock1')
        known = bench.epoch
        bench.robot(*interrupted, 'Stopping', 'Stopped')
        assert bench.epoch != known
        assert bench.sent == ['dock'], 'the robot has read it, so it was stopped'
        if interrupted:
            assert outcome(dock) is Outcome.INTERRUPTED

    def test_a_drive_that_was_not_sent_is_not_sent_after_it(self, bench):
        known = driving(bench)
        drive = bench.dispatcher.start(parse_command('goto 14'), giver=ROUTE, known_epoch=known)
        bench.robot('Stopping')
        assert (outcome(drive), bench.sent) == (Outcome.OVERRULED, ['goto 12'])


def test_a_docked_robot_that_says_so_again_has_not_carried_out_the_drives_to_come(bench):
    bench.status(DOCKED)
    goto, dock = bench.drive(PERSON), bench.drive(ROUTE, 'dock')
    bench.robot(DOCKED.replace('Bulk', 'Float'))
    assert (goto.result, dock.result) == (None, None)


def test_a_drive_that_others_complete_is_not_ours_to_the_same_goal_before_a_stop(bench):
    bench.status('Going to 3')
    bench.status('Going to 3')
    first, second = bench.drive(ROUTE, 'goto 2'), bench.drive(PERSON, 'goto 3')
    bench.stop(PERSON)
    bench.robot('Arrived at 3')
    assert (first.result, second.result) == (None, None), 'the robot has not read our drives'
    bench.robot('Going to 2', 'Interrupted: Going to 2', 'Going to 3', 'Interrupted: Going to 3',
                'Stopping', 'Stopped')
    assert (outcome(first), outcome(second)) == (Outcome.INTERRUPTED, Outcome.INTERRUPTED)
    assert not bench.memory.stop_owed


def test_a_robot_that_docks_for_another_client_and_says_so_again_has_not_read_our_dock(bench):
    bench.status(DOCKING)
    bench.status(DOCKING)
    dock = bench.drive(ROUTE, 'dock')
    bench.robot(DOCKING.replace('Not', 'Bulk'), UNDOCKED, 'Interrupted: Going to dock at Dock',
                UNDOCKED)
    assert dock.result is None, 'the drive of the other client was interrupted'
    bench.robot(DOCKING)
    assert bench.memory.giver == ROUTE
    bench.robot(DOCKED)
    assert outcome(dock) is Outcome.SUCCEEDED


def test_a_drive_that_was_stopped_in_the_dock_is_not_still_to_be_answered(bench):
    bench.status(DOCKED)
    drive = bench.drive(ROUTE, number=7)
    bench.robot(UNDOCKING, UNDOCKED, 'Interrupted: Undocking', 'Stopping', 'Stopped')
    assert outcome(drive) is Outcome.INTERRUPTED
    bench.status('Stopped')
    assert [last.fate for last in bench.memory.last_commands] == [CommandFate.NOT_OBEYED]
    bench.drive(PERSON, 'goto 3', known_epoch=bench.epoch)


@pytest.mark.parametrize('how', ['lost link', 'restart'])
def test_what_others_drove_before_is_theirs_after_an_outage_also_if_it_might_lead_to_our_dock(
        bench, how):
    """Some robots name their dock as a goal."""
    bench.robot('Going to 7')
    bench.drive(PERSON, 'dock')  # lost with the link
    bench = after_outage(bench, how)
    bench.status('Going to 7')
    assert (bench.memory.giver, bench.memory.ruling.kind) == (NO_GIVER, RecordKind.FOREIGN_DRIVE)


@pytest.mark.parametrize('how', ['lost link', 'restart'])
@pytest.mark.parametrize('ours, status, interruption', [
    ('dock', DOCKING, 'Interrupted: Going to dock at Dock'),
    ('goto 12', 'Going to 12', 'Interrupted: Going to 12')])
def test_after_an_outage_the_robot_may_break_off_our_drive_for_another_client(
        bench, how, ours, status, interruption):
    """After the interruption, the other client's goal is not on the way to our dock."""
    bench.drive(PERSON, ours)
    bench.robot(status)
    bench = after_outage(bench, how)
    bench.status(status)
    assert bench.memory.giver == PERSON
    bench.robot(interruption, 'Going to 3')
    assert (bench.memory.giver, bench.memory.ruling.kind) == (NO_GIVER, RecordKind.FOREIGN_DRIVE)


def test_a_goal_of_a_drive_to_be_answered_first_is_not_on_the_way_to_the_dock(bench):
    bench.drive(ROUTE, 'goto 3')
    bench.robot('EStop pressed', 'EStop relieved but motors still disabled', 'Motors enabled')
    dock = bench.drive(PERSON, 'dock')  # comes after the stop that is owed for the drive
    bench.robot('Going to 3', 'Interrupted: Going to 3', 'Stopping', 'Stopped', UNDOCKED, DOCKING)
    assert (dock.result, bench.has_begun(dock), bench.memory.giver) == (None, True, PERSON)


@pytest.mark.parametrize('before', [[], ['goto 3']])
@pytest.mark.parametrize('ours, begins, ends', [
    ('gotoPoint 1 2', 'Going to point', 'Arrived at point'),
    ('goto 12', 'Going to 12', 'Arrived at 12')])
def test_a_drive_that_others_complete_is_not_ours_which_the_robot_has_still_to_read(
        bench, before, ours, begins, ends):
    bench.robot(begins)
    for text in before:
        bench.drive(ROUTE, text)
    drive = bench.drive(PERSON, ours)
    bench.robot(ends)
    assert (drive.result, bench.has_begun(drive)) == (None, False)
    bench.robot(*(text.replace('goto', 'Going to') for text in before), begins, ends)
    assert outcome(drive) is Outcome.SUCCEEDED


def test_a_point_is_not_that_of_a_drive_behind_another_one_to_be_read(bench):
    bench.drive(ROUTE, 'goto 3')
    drive = bench.drive(PERSON, 'gotoPoint 1 2')
    bench.robot('Going to point')
    assert (bench.has_begun(drive), bench.memory.cause) == (False, MotionCause.OTHER_CLIENT)


class TestTheEmergencyStop:
    def test_begins_an_epoch_when_it_is_pressed_again_before_the_motors_are_on(self, bench):
        bench.robot('EStop pressed', 'EStop relieved but motors still disabled')
        known = bench.epoch
        bench.status('EStop relieved but motors still disabled')
        assert bench.epoch == known
        bench.robot('EStop pressed')
        assert (bench.epoch != known, bench.records.motion.emergency_stop) == (True, True)

    def test_may_be_told_as_an_error_also_of_an_idle_robot(self, bench):
        known = bench.epoch
        bench.robot('Error: Emergency stop pressed')
        assert (bench.epoch != known, bench.records.motion.emergency_stop) == (True, True)


class TestOurStop:
    def test_is_not_overtaken_by_the_drive_that_it_was_given_for(self, bench):
        driving(bench)
        bench.lose()
        bench.stop_without_link(PERSON)
        bench.connect()
        bench.pass_time(LOOK)
        assert bench.sent[-1] == 'stop'
        for _ in range(8):
            bench.status('Going to 12', 1.5)
        assert bench.memory.stop_owed

    @pytest.mark.parametrize('lines', [['Stopping', 'Going to 9'],
                                       ['Stopping', 'Stopped', 'Going to 9']])
    def test_is_owed_though_another_client_stops_and_drives_before_the_drive_to_be_stopped(
            self, bench, lines):
        """Once, the robot drove on to 12 after an outage, and was not stopped."""
        bench.drive(PERSON)
        bench.stop(PERSON)
        bench.robot(*lines)
        assert bench.memory.stop_owed
        after_outage(bench)
        bench.status('Going to 12')
        bench.pass_time(LOOK)
        assert bench.sent == ['goto 12', 'stop', 'stop']

    def test_is_owed_until_the_drive_is_over_that_was_on_its_way_at_an_emergency_stop(self, bench):
        bench.drive(PERSON)
        known = bench.epoch
        bench.robot('EStop pressed', 'Motors enabled', 'Stopping', 'Stopped',
                    'Stopping', 'Going to 12')  # the last `Stopping` is another client's stop
        assert (bench.epoch != known, bench.memory.stop_owed) == (True, True)
        known = bench.epoch
        bench.robot('Interrupted: Going to 12', 'Stopping', 'Stopped')
        assert (bench.epoch, bench.memory.stop_owed, bench.sent) == (
            known, False, ['goto 12', 'stop'])

    def test_for_a_drive_that_timed_out_ends_no_newer_drive(self, bench):
        older = bench.drive(ROUTE, stop_on_timeout=True)
        bench.pass_time(30.0)
        bench.drive(PERSON, 'goto 3')
        bench.pass_time(31.0)
        assert outcome(older) is Outcome.TIMED_OUT
        bench.pass_time(1.0)
        assert bench.sent == ['goto 12', 'goto 3']

    def test_a_cancellation_of_everything_is_none_of_another_clients_drive(self, bench):
        bench.robot('Going to 5')
        known = bench.epoch
        bench.records.all_cancelled(PERSON)
        assert (bench.epoch != known, bench.memory.giver, bench.sent) == (True, NO_GIVER, [])


class TestAnswers:
    @pytest.mark.parametrize('text', ['say hello', 'undock', 'doTask wait 5'])
    def test_a_refusal_is_that_of_the_command_that_it_names(self, bench, text):
        """Once, the refusal counted for a drive that the robot has still to answer."""
        bench.drive(ROUTE, 'gotoPoint 1 2')
        bench.robot('EStop pressed')  # sent before `gotoPoint` reached the robot
        refused = bench.give(text, giver=PERSON)
        bench.robot(f'CommandError: {text}', 'CommandErrorDescription: no')
        assert outcome(refused) is Outcome.REJECTED

    def test_an_unknown_command_is_not_the_drive_that_the_robot_carries_out(self, bench):
        begun = bench.drive(ROUTE)
        bench.robot('Going to 12')
        newer = bench.drive(PERSON, 'goto 14')
        bench.robot('Unknown command goto')
        assert (begun.result, outcome(newer)) == (None, Outcome.UNKNOWN_COMMAND)

    def test_lines_that_waited_refute_a_doubt_of_before(self, bench):
        """The robot showed `Stopped` for an instant; then this process was suspended."""
        drive = bench.drive(ROUTE)
        bench.robot('Going to 12')
        bench.status('Stopped', 1.0)
        bench.now += 20.0
        bench.robot('Goal: 3', 'Status: Going to 12 Location: 0 0 0')
        bench.pass_time(10.0)
        assert drive.result is None

    def test_a_stop_that_comes_late_lets_no_older_drive_come_again(self, bench):
        known = bench.epoch
        bench.drive(ROUTE, number=8, known_epoch=known)
        bench.robot('Going to 12')
        bench.stop(ROUTE, number=7, known_epoch=known)
        with pytest.raises(Overruled):
            bench.drive(ROUTE, number=8, known_epoch=known)
