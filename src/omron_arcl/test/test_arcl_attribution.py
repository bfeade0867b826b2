"""Each line of the robot ends the right command with the right outcome; shown with transcripts."""
from __future__ import annotations

from typing import Sequence

import pytest
from arcl_builders import DOCK, GOTO_FROM_DOCK, STATUS, UNDOCK, Conversation, outcome

from omron_arcl import Outcome


@pytest.fixture
def talk() -> Conversation:
    return Conversation()


def check_that_the_last_line_ends(talk: Conversation, command: str, lines: Sequence[str]) -> None:
    """Checks that the last of these lines ends the command, and that no earlier line does."""
    execution = talk.give(command)
    talk.robot(*lines[:-1])
    assert execution.result is None
    talk.robot(lines[-1])
    assert outcome(execution) is Outcome.SUCCEEDED
    assert execution.result.lines == lines


# --- transcripts ----------------------------------------------------------------------------------

def test_goto_from_the_dock_ends_with_the_arrival(talk):
    check_that_the_last_line_ends(talk, 'goto 12', GOTO_FROM_DOCK)


def test_a_bad_goal_and_a_bad_command_and_a_stop(talk):
    bad_goal, bad_command = talk.give('goto 99'), talk.give('gooto 12')
    talk.robot('CommandError: goto 99', "CommandErrorDescription: No goal '99'",
               'Unknown command gooto')
    assert outcome(bad_goal) is Outcome.NO_GOAL
    assert bad_goal.result.words == "No goal '99'"
    assert outcome(bad_command) is Outcome.UNKNOWN_COMMAND
    goto = talk.give('goto 12')
    talk.robot('Going to 12')
    stop = talk.give('stop')
    talk.robot('Interrupted: Going to 12', 'Stopping', 'Stopped')
    assert outcome(goto) is Outcome.INTERRUPTED
    assert goto.result.words == 'Interrupted: Going to 12'
    assert outcome(stop) is Outcome.SUCCEEDED
    assert stop.result.lines == ('Interrupted: Going to 12', 'Stopping', 'Stopped')


def test_dock_and_undock(talk):
    dock = talk.give('dock')
    talk.robot(*DOCK[:3])
    assert dock.result is None
    talk.robot(*DOCK[3:])
    assert outcome(dock) is Outcome.SUCCEEDED
    undock = talk.give('undock')
    talk.robot(*UNDOCK)
    assert outcome(undock) is Outcome.SUCCEEDED


def test_lines_of_the_outgoing_link_end_nothing(talk):
    goto = talk.give('goto 12')
    talk.robot('Going to 12')
    talk.robot(*(line.decode() for line in STATUS), 'RangeDeviceGetCurrent: Laser_1 1 2',
               'Goal: 12', 'End of goals', 'Odometer: 8281 mm 210 deg 469 sec',
               'End of ApplicationFaultQuery')
    assert goto.result is None
    assert talk.has_begun(goto)


# --- ends of drives -------------------------------------------------------------------------------

@pytest.mark.parametrize(('text', 'lines'), [
    ('goto x', ('Going to X', 'Arrived at X')),
    ('goto "goal space"', ('Going to goal space', 'Arrived at goal space')),
    ('gotoPoint 1 2 3', ('Going to point', 'Arrived at point')),
    ('gotoPoint 1 2 3', ('Going to point 1 2 3', 'Arrived at point 1 2 3')),
    ('gotoPoint -597 -5765 90', ('Going to -597 -5765', 'Arrived at -597 -5765')),
    ('gotoRouteGoal r g', ('Going to g', 'Arrived at g')),
    ('doTask gotoPoint 1 2 3', ('Will do task gotoPoint 1 2 3', 'Doing task gotoPoint 1 2 3',
                                'Going to point', 'Completed doing task gotoPoint 1 2 3')),
    ('doTask wait 10', ('Will do task wait 10', 'Doing task wait 10',
                        'WaitState: Waiting 10 seconds with status "Waiting"',
                        'WaitState: Waiting completed', 'Completed doing task wait 10')),
    ('executeMacro Adept Greeting', ('Executing macro Adept Greeting',
                                     'WaitState: Waiting completed',
                                     'Completed macro Adept Greeting')),
    ('patrolOnce r', ('Patrolling route r once', 'Finished patrolling route r')),
    ('listExecute', ('Executing list', 'Doing task move 1', 'Completed doing task move 1',
                     'Successfully finished task list')),
    ('localizeToPoint 1 2 3', ('Localizing at point', 'Localized to point')),
    ('enableMotors', ('Motors are enabled',)),
    ('undock', ('DockingState: Undocked ForcedState: Unforced ChargeState: Not',)),
])
def test_a_command_succeeds_with_its_last_line(talk, text, lines):
    check_that_the_last_line_ends(talk, text, lines)


@pytest.mark.parametrize(('said', 'expected', 'words'), [
    ('Error: Failed going to goal', Outcome.FAILED, 'Failed going to goal'),
    ('Failed going to 12', Outcome.FAILED, 'Failed going to 12'),
    ('EStop pressed', Outcome.EMERGENCY_STOPPED, 'EStop pressed'),
    ('Estop pressed', Outcome.EMERGENCY_STOPPED, 'Estop pressed'),
    ('Motors disabled', Outcome.FAILED, 'Motors disabled'),
    ('Interrupted: Going to 12', Outcome.INTERRUPTED, 'Interrupted: Going to 12'),
    ('Going to 13', Outcome.INTERRUPTED, 'taken over: Going to 13'),
    ('Patrolling route r', Outcome.INTERRUPTED, 'taken over: Patrolling route r'),
])
def test_a_drive_that_fails_carries_the_robots_words(talk, said, expected, words):
    goto = talk.give('goto 12')
    talk.robot('Going to 12', said)
    assert outcome(goto) is expected
    assert goto.result.words == words


@pytest.mark.parametrize('said', [
    'Arrived at 13', 'Interrupted: Going to 13', 'Stopped', 'Stopping', 'Going to 12',
    'EStop relieved but motors still disabled', 'Motors enabled', 'Parking', 'WaitState: x',
    'Map changed', 'Failed going to 13', 'hello', 'CommandError: goto 13',
])
def test_what_is_about_something_else_does_not_end_a_drive(talk, said):
    goto = talk.give('goto 12')
    talk.robot('Going to 12', said)
    assert goto.result is None


@pytest.mark.parametrize(('text', 'acknowledged', 'seconds'), [
    ('goto 12', 'Going to 12', 600.0), ('gotoPoint 1 2', 'Going to point', 600.0),
    ('doTask wait 7', 'Doing task wait 7', 3600.0), ('patrol r', 'Patrolling route r', 3600.0),
    ('dock', DOCK[1], 180.0), ('undock', UNDOCK[0], 60.0), ('stop', 'Stopping', 15.0),
])
def test_a_motion_of_which_nothing_is_heard_any_more_times_out(talk, text, acknowledged, seconds):
    execution = talk.give(text)
    talk.robot(acknowledged)
    talk.pass_time(seconds - 1.0)
    assert execution.result is None
    talk.pass_time(2.0)
    assert outcome(execution) is Outcome.TIMED_OUT
    assert f'{seconds:.0f} s' in execution.result.words


def test_a_drive_that_never_begins_times_out_only_after_the_dock_had_time(talk):
    goto = talk.give('goto 12')
    talk.pass_time(50.0)
    assert goto.result is None
    talk.pass_time(20.0)
    assert outcome(goto) is Outcome.TIMED_OUT


def test_a_timeout_counts_the_silence_and_a_status_about_the_drive_breaks_it(talk):
    goto = talk.give('goto 12', timeout=5.0)
    talk.robot('Going to 12')
    for _ in range(5):
        talk.pass_time(4.0)
        talk.robot('Status: Going to 12 Location: 1 2 3')
    assert goto.result is None
    talk.pass_time(4.0)
    talk.robot('Status: Stopped Location: 1 2 3')
    talk.pass_time(2.0)
    assert outcome(goto) is Outcome.TIMED_OUT


def test_a_second_try_to_dock_belongs_to_the_same_command(talk):
    """The ARCL manual I617-E-02, p. 71, describes such a robot."""
    dock = talk.give('dock')
    states = ('Undocked', 'Docking', 'Undocking', 'Undocked', 'Docking', 'Docking', 'Docked')
    lines = [f'DockingState: {state} ForcedState: Unforced ChargeState: Not' for state in states]
    for line in lines[:-1]:
        talk.robot(line)
        talk.pass_time(5.0)
        assert dock.result is None, line
    talk.robot(lines[-1])
    assert outcome(dock) is Outcome.SUCCEEDED
    assert dock.result.lines == tuple(lines)


@pytest.mark.parametrize(('text', 'lines'), [
    ('getDataStoreGroupValues FleetRobotInformation', (
        'GetDataStoreGroupValues: Robots 5', 'GetDataStoreGroupValues: RobotsAvail 3',
        'EndOfGetDataStoreGroupValues')),
    ('getDataStoreFieldValues ParkingTime', (
        'GetDataStoreFieldValues: ParkingTime 773.984', 'EndOfGetDataStoreFieldValues')),
    ('getDataStoreTripGroupList', (
        'GetDataStoreTripGroupList: TripJobCounts', 'EndOfGetDataStoreTripGroupList')),
    ('getDataStoreFieldInfo AggParkingTime', (
        'GetDataStoreFieldInfo: Double AggParkingTime Intermediate 0 inf "(hours)" "" ""',
        'EndOfGetDataStoreFieldInfo')),
    ('tripReset', ('tripReset: TripCompletedJobs 0', 'EndOfTripReset')),
    ('extIODump', (
        'ExtIODump: example with 69 input(s), value = 0x000000000ff000000 and 37 output(s), '
        'value = 0x1f00000000', 'EndExtIODump')),
    ('extIOAdd example 69 37', (
        'extIOAdd: example added with 69 input(s) and 37 output(s)',)),
    ('extIOInputUpdate example2 32', (
        'extIOInputUpdate: input example2 updated with 0x00000000000000020 from 32',)),
    ('extIOOutputUpdateBit example 35 1', (
        'extIOOutputUpdateBit: output example updated with 1 at bit 35 to 0x400000000',)),
    ('extIORemove example', ('extIORemove: example removed',)),
    ('payloadQueryLocal default hello', (
        'PayloadQuery: 1 "slotjunk" 05/07/2012 21:11:33 hello', 'EndPayloadQuery')),
    ('payloadSlotCountLocal', (
        'PayloadSlotCount: "OAT_Telepresence_Robot" 4', 'EndPayloadSlotCount')),
    ('payloadSet 1 Books', (
        'payloadset attempting to set payload 1 "Books"',
        'payloadset on "OAT" of slot number 1 with string "Books" successfully set')),
    ('payloadRemove 4', (
        'payloadremove attempting to remove slot 4',
        'payloadremove on 31 of slot number 4 successfully')),
    ('queueQueryLocal status completed', (
        'QueueQuery: DROPOFF18 y4rt 22 Completed None Goal "x" "MT-490" 12/19/2011 07:07:53 '
        '12/19/2011 07:08:07 xyz 0', 'EndQueueQuery')),
    ('queueShowRobotLocal echoit', (
        'QueueRobot: "Robot1" UnAvailable EStopPressed echoit', 'EndQueueShowRobot')),
    ('queueCancelLocal robotname x', (
        'queuecancel attempting to cancel "robotname" "B" "" "None"',
        'queuecancel cancelling "robotname" "B" "" "None" from queue')),
    ('queueModifyLocal dropoff6 goal x', ('queuemodifylocal modifying id dropoff6 goal "x"',)),
    ('queueDropoff x 22 y4rt', (
        'queuedropoff attempting to queue goal "x" with priority 22',
        'queuedropoff goal "x" with priority 22, id DROPOFF18 and job_id y4rt successfully queued',
        'QueueUpdate: DROPOFF18 y4rt 22 Pending None Goal "x" "MT" 12/19/2011 07:07:53 None None 0',
        'Going to X', 'Arrived at X')),
    ('waitTaskCancel', ('WaitTask: Wait cancelled',)),
    ('inputList', ('Input: digin1', 'End of inputList')),
    ('analogInputList', (
        'AnalogInputListHelper: List format is: <minV> <maxV> <maxRaw> <name>',
        'End of AnalogInputList')),
])
def test_the_manuals_examples_of_i617_e_02_end_as_it_says(talk, text, lines):
    check_that_the_last_line_ends(talk, text, lines)


def test_the_update_of_another_set_of_inputs_and_outputs_ends_nothing(talk):
    update = talk.give('extIOInputUpdate example 1')
    talk.robot('extIOInputUpdate: input other updated with 0x1 from 1')
    assert update.result is None


@pytest.mark.parametrize('text', ['goto 12', 'modeLock 1'])
def test_a_command_that_lacks_arguments_is_rejected_by_its_syntax(talk, text):
    execution, other = talk.give(text), talk.give('odometer')
    talk.robot(f'usage: {text.split()[0].lower()} <more> [and more]')
    assert outcome(execution) is Outcome.REJECTED
    assert '<more>' in execution.result.words
    assert other.result is None


# --- other spellings ------------------------------------------------------------------------------

@pytest.mark.parametrize(('given', 'echoed'), [
    ('gotoPoint 100 200 0', 'gotoPoint 100.0 200.0 0.0'), ('say "$g is full"', 'say "12 is full"'),
    ('wait 10', 'WAIT 10'), ('move 1000 400', '"move" 1000 400')])
def test_a_task_is_known_though_its_arguments_are_written_otherwise(talk, given, echoed):
    task = talk.give(f'doTask {given}')
    talk.robot(f'Will do task {echoed}', f'Doing task {echoed}', f'Completed doing task {echoed}')
    assert outcome(task) is Outcome.SUCCEEDED


def test_another_clients_task_is_not_ours(talk):
    task = talk.give('doTask wait 60')
    talk.robot('Doing task wait 60', 'Doing task wait 5')
    assert outcome(task) is Outcome.INTERRUPTED


@pytest.mark.parametrize(('text', 'lines'), [
    ('distanceFromHere Goal1', ('DistanceFromHere: 12345 "Goal1"',)),
    ('queueQueryLocal status completed', ('EndQueueQueryLocal',)),
    ('queueShowRobotLocal', ('QueueRobot: "Robot1" Available Available', 'EndQueueShowRobotLocal')),
    ('help', ('Commands:', 'goto                        Goes', 'stop Stops', 'End of commands')),
])
def test_queries_are_answered_in_the_robots_own_words(talk, text, lines):
    query = talk.give(text)
    talk.robot(*lines)
    assert outcome(query) is Outcome.SUCCEEDED
    assert query.result.lines == lines


def test_a_robot_that_docks_by_itself_takes_the_drive_over(talk):
    goto = talk.give('goto 12')
    talk.robot('DockingState: Undocked ForcedState: Unforced ChargeState: Not', 'Going to 12',
               DOCK[1])
    assert outcome(goto) is Outcome.INTERRUPTED
    assert 'taken over' in goto.result.words


def test_a_docking_state_with_a_field_of_a_newer_robot_is_understood(talk):
    dock = talk.give('dock')
    talk.robot(*(f'{line} BatteryState: Good' for line in DOCK[:4]))
    assert outcome(dock) is Outcome.SUCCEEDED


@pytest.mark.parametrize('former, command', [
    ('goto 99', 'goto 3'), ('goto 99 90', 'goto 3 90'), ('gotoPoint 100 200', 'gotoPoint 300 400'),
    ('gotoRouteGoal r 99', 'gotoRouteGoal r 3')])
def test_a_refusal_that_names_another_goal_is_of_a_command_that_has_ended(talk, former, command):
    """The robot answers the former command late, and carries out the newer drive.

    If the newer drive counted as refused, the robot would drive without a giver.
    """
    first = talk.give(former)
    talk.robot('EStop pressed', 'EStop relieved but motors still disabled', 'Motors enabled')
    assert outcome(first) is Outcome.EMERGENCY_STOPPED
    drive = talk.give(command)
    talk.robot(f'CommandError: {former}', "CommandErrorDescription: No goal '99'")
    assert drive.result is None
    talk.robot('Going to point' if 'Point' in command else 'Going to 3')
    assert talk.has_begun(drive)


@pytest.mark.parametrize('command, said', [
    ('goto 3 90', 'goto'), ('goto 3 90', 'goto "3"'), ('goto 3 90', 'GOTO 3 90.0'),
    ('gotoPoint 100.4 200', 'gotoPoint 100 200'), ('gotoRouteGoal r 3', 'gotoRouteGoal "r" 3'),
    ('gotoPoint 100 200', 'gotoPoint 100 200 0'), ('goto Goal 3', 'goto "Goal 3"')])
def test_a_refusal_may_spell_the_command_in_another_way(talk, command, said):
    drive = talk.give(command)
    talk.robot(f'CommandError: {said}', 'CommandErrorDescription: no')
    assert outcome(drive) is Outcome.REJECTED
