"""A drive ends when the robot says so, in any words, or when only its status shows the end."""
from __future__ import annotations

from typing import Optional, Tuple

import pytest
from arcl_builders import DOCK, Conversation, outcome

from omron_arcl import ActivityKind, Execution, Outcome, judgements
from omron_arcl.commands import DriveCourse


@pytest.fixture
def talk() -> Conversation:
    return Conversation()


def begun(talk: Conversation, text: str = 'goto 12', *said: str) -> Execution:
    """Returns a command that the robot has acknowledged."""
    execution = talk.give(text)
    talk.robot(*(said or ('Going to 12',)))
    assert talk.has_begun(execution)
    return execution


def shows(talk: Conversation, status: str, seconds: float = 60.0) -> None:
    """Plays the same status for this time; a status comes every 1.5 s."""
    for _ in range(int(seconds / 1.5)):
        talk.pass_time(1.4)
        talk.robot(f'Status: {status} StateOfCharge: 79.4 Location: 1 2 3 Temperature: 36')


@pytest.mark.parametrize('said', [
    ('Interrupted: Going to -597 -5765', 'Stopping', 'Stopped'),  # ARCL manual I617-E-02 p. 243
    ('Interrupted: Going to point', 'Stopping', 'Stopped'),
])
def test_a_drive_that_somebody_stops_ends_with_stopped_though_its_goal_is_not_named(talk, said):
    goto = begun(talk)
    talk.robot(*said)
    assert outcome(goto) is Outcome.INTERRUPTED
    assert goto.result.words == said[0]


@pytest.mark.parametrize(('text', 'acknowledged'), [
    ('goto 12', 'Going to 12'), ('gotoPoint 1 2', 'Going to point'),
    ('gotoRouteGoal r 12', 'Going to 12')])
@pytest.mark.parametrize('said', [('Stopping', 'Stopped'), ('Stopped',), ('Parked',),
                                  ('Teleop driving',), ('Interrupted: Going to -597 -5765',)])
def test_a_stop_without_a_word_of_the_drive_ends_it_within_ten_seconds(
        talk, text, acknowledged, said):
    goto = begun(talk, text, acknowledged)
    talk.robot(*said)
    talk.pass_time(3.0)
    assert goto.result is None, 'the status may last only an instant'
    talk.pass_time(7.0)
    assert outcome(goto) is Outcome.INTERRUPTED


def test_a_moment_of_stopping_ends_nothing_when_the_robot_drives_on(talk):
    goto = begun(talk)
    talk.robot('Stopping')
    shows(talk, 'Going to 12')
    assert goto.result is None
    talk.robot('Arrived at 12')
    assert outcome(goto) is Outcome.SUCCEEDED


@pytest.mark.parametrize(('status', 'expected'), [
    ('Arrived at 12', Outcome.SUCCEEDED),
    ('Stopped', Outcome.INTERRUPTED), ('Arrived at 13', Outcome.INTERRUPTED),
    ('Going to 13', Outcome.INTERRUPTED), ('Parked', Outcome.INTERRUPTED),
    ('Teleop driving', Outcome.INTERRUPTED), ('Patrolling route r', Outcome.INTERRUPTED),
    (DOCK[3], Outcome.INTERRUPTED), ('Interrupted: Going to 12', Outcome.INTERRUPTED),
    ('Failed going to 12', Outcome.FAILED), ('Error: Failed going to goal', Outcome.FAILED),
    ('Robot lost', Outcome.FAILED), ('Motors disabled', Outcome.FAILED),
    ('EStop pressed', Outcome.EMERGENCY_STOPPED),
    ('EStop relieved but motors still disabled', Outcome.EMERGENCY_STOPPED),
])
def test_a_status_that_contradicts_a_drive_for_some_seconds_ends_it(talk, status, expected):
    goto = begun(talk)
    shows(talk, status, seconds=4.0)
    assert goto.result is None
    shows(talk, status, seconds=4.0)
    assert outcome(goto) is expected
    assert goto.result.words == f'the robot\'s status is "{status}"'


@pytest.mark.parametrize('status', ['Going to 12', 'going to 12', 'Waiting for a door', 'Driving',
                                    'Going to -597 -5765', 'Going to point'])
def test_a_status_of_the_drive_or_of_unknown_meaning_ends_nothing(talk, status):
    goto = begun(talk)
    shows(talk, status, seconds=120.0)
    assert goto.result is None


def test_a_status_of_unknown_meaning_keeps_no_drive_alive_for_ever(talk):
    goto = begun(talk)
    shows(talk, 'Waiting for a door', seconds=615.0)
    assert outcome(goto) is Outcome.TIMED_OUT


def test_one_status_to_the_contrary_ends_nothing_while_others_follow(talk):
    goto = begun(talk)
    for _ in range(20):
        shows(talk, 'Stopped', 1.5)
        shows(talk, 'Going to 12', 1.5)
    assert goto.result is None


def test_one_status_to_the_contrary_after_which_no_other_comes_ends_the_drive(talk):
    goto = begun(talk)
    talk.pass_time(10.0)
    shows(talk, 'Stopped', 1.5)
    talk.pass_time(8.0)
    assert goto.result is None
    talk.pass_time(2.0)
    assert outcome(goto) is Outcome.INTERRUPTED


def test_a_robot_that_names_the_point_of_its_goal_is_understood(talk):
    goto = begun(talk)
    shows(talk, 'Going to -597 -5765', 6.0)
    other = begun(talk, 'goto 13', 'Going to 13')
    assert outcome(goto) is Outcome.INTERRUPTED
    shows(talk, 'Going to -100 200', 6.0)
    shows(talk, 'Arrived at -100 200', 6.0)
    assert outcome(other) is Outcome.SUCCEEDED


def test_a_drive_is_interrupted_by_the_name_of_its_point_once_that_is_known(talk):
    goto = begun(talk)
    shows(talk, 'Going to -597 -5765', 6.0)
    talk.robot('Interrupted: Going to -597 -5765')
    assert outcome(goto) is Outcome.INTERRUPTED


@pytest.mark.parametrize('asks_before', [True, False])
def test_a_status_that_answers_an_older_question_says_nothing_about_the_command(
        talk, asks_before):
    """This holds however late the status comes."""
    for text in ('oneLineStatus', 'stop') if asks_before else ('stop', 'oneLineStatus'):
        talk.give(text)
    talk.pass_time(3.0)
    talk.robot('Status: Stopped StateOfCharge: 79.4 Location: 1 2 3 Temperature: 36')
    assert talk.dispatcher.in_doubt is not asks_before


def test_a_status_right_after_the_command_may_be_the_one_before(talk):
    begun(talk)
    goto = talk.give('goto 12')
    talk.robot('Status: Arrived at 12 Location: 1 2 3')
    talk.pass_time(5.0)
    assert goto.result is None


# --- drives that the robot has not acknowledged ---------------------------------------------------

def test_a_robot_that_shows_the_goal_has_begun_though_it_did_not_say_so(talk):
    goto = talk.give('goto 12')
    shows(talk, 'Going to 12', 3.0)
    assert talk.has_begun(goto)
    talk.robot('Interrupted: Going to 12')
    assert outcome(goto) is Outcome.INTERRUPTED


def test_a_robot_that_stands_at_the_goal_has_arrived_though_it_did_not_say_so(talk):
    goto = talk.give('goto 12')
    shows(talk, 'Arrived at 12', 9.0)
    assert outcome(goto) is Outcome.SUCCEEDED


def test_a_robot_without_motors_does_not_begin(talk):
    goto = talk.give('goto 12')
    shows(talk, 'EStop pressed', 9.0)
    assert outcome(goto) is Outcome.EMERGENCY_STOPPED


def test_a_robot_that_stands_elsewhere_may_still_begin(talk):
    goto = talk.give('goto 12')
    shows(talk, 'Stopped', 30.0)
    assert goto.result is None


# --- docking, tasks -------------------------------------------------------------------------------

def test_the_way_to_the_dock_may_be_long(talk):
    dock = talk.give('dock')
    shows(talk, 'Going to dock at Dock1', 300.0)
    assert dock.result is None
    talk.robot(*DOCK)
    assert outcome(dock) is Outcome.SUCCEEDED


def test_a_robot_that_gave_up_docking_ends_it_within_a_minute(talk):
    dock = begun(talk, 'dock', *DOCK[:2])
    shows(talk, 'Stopped', 27.0)
    assert dock.result is None, 'the robot may try again'
    shows(talk, 'Stopped', 9.0)
    assert outcome(dock) is Outcome.INTERRUPTED


def test_a_docked_robot_has_docked_though_it_did_not_say_so(talk):
    dock = begun(talk, 'dock', *DOCK[:2])
    shows(talk, DOCK[3], 9.0)
    assert outcome(dock) is Outcome.SUCCEEDED


@pytest.mark.parametrize(('text', 'acknowledged', 'shown', 'done'), [
    ('doTask wait 60', 'Doing task wait 60', 'Waiting', 'Completed doing task wait 60'),
    ('executeMacro m', 'Executing macro m', 'Going to 3', 'Completed macro m'),
    ('patrolOnce r', 'Patrolling route r once', 'Arrived at 3', 'Finished patrolling route r'),
])
def test_a_task_shows_what_it_likes_and_ends_with_its_own_words(
        talk, text, acknowledged, shown, done):
    execution = begun(talk, text, acknowledged)
    shows(talk, shown, 100.0)
    assert execution.result is None
    talk.robot(done)
    assert outcome(execution) is Outcome.SUCCEEDED


def test_a_task_whose_last_word_was_not_said_ends_by_the_status(talk):
    task = begun(talk, 'doTask wait 60', 'Doing task wait 60')
    shows(talk, 'Completed doing task wait 60', 9.0)
    assert outcome(task) is Outcome.SUCCEEDED


def test_a_task_that_somebody_stopped_without_a_word_ends_within_a_minute(talk):
    task = begun(talk, 'doTask wait 600', 'Doing task wait 600')
    shows(talk, 'Stopped', 45.0)
    assert outcome(task) is Outcome.INTERRUPTED


# --- stops ----------------------------------------------------------------------------------------

@pytest.mark.parametrize('status', ['Stopped', 'Arrived at 12', 'EStop pressed', DOCK[3],
                                    'Interrupted: Going to 12'])
def test_a_stop_is_obeyed_once_the_robot_stands_though_it_did_not_say_so(talk, status):
    goto = begun(talk)
    stop = talk.give('stop')
    shows(talk, status, 6.0)
    assert outcome(stop) is Outcome.SUCCEEDED
    assert goto.result is not None, 'the drive must end with the stop'


def test_a_stop_that_the_robot_ignores_times_out(talk):
    goto = begun(talk)
    shows(talk, 'Going to 12', 3.0)
    stop = talk.give('stop')
    shows(talk, 'Going to 12', 18.0)
    assert outcome(stop) is Outcome.TIMED_OUT
    assert goto.result is None


def test_a_stop_is_interrupted_when_somebody_else_drives(talk):
    shows(talk, 'Going to 12', 3.0)
    stop = talk.give('stop')
    shows(talk, 'Going to 13', 12.0)
    assert outcome(stop) is Outcome.INTERRUPTED
    assert 'Going to 13' in stop.result.words


def test_a_doubt_asks_for_a_status(talk):
    begun(talk)
    assert not talk.dispatcher.in_doubt
    talk.robot('Stopping')
    assert talk.dispatcher.in_doubt
    talk.robot('Status: Stopped Location: 1 2 3')
    assert talk.dispatcher.in_doubt
    talk.pass_time(1.0)
    talk.robot('Status: Going to 12 Location: 1 2 3')
    assert not talk.dispatcher.in_doubt


DOCKED, UNDOCKING, UNDOCKED = (
    f'DockingState: {state} ForcedState: Unforced ChargeState: Not'
    for state in ('Docked', 'Undocking', 'Undocked'))
TO_DOCK = 'Going to dock at Dock 1'


def setting_out(talk: Conversation, before: str = DOCKED, text: str = 'goto 12',
                sign: str = UNDOCKING) -> Execution:
    """Returns a drive that the robot visibly carries out, but has not acknowledged."""
    talk.robot(f'Status: {before} StateOfCharge: 79.4 Location: 1 2 3 Temperature: 36')
    execution = talk.give(text)
    talk.robot(sign)
    assert not talk.has_begun(execution)
    return execution


@pytest.mark.parametrize(('text', 'before', 'sign'), [
    ('goto 12', DOCKED, UNDOCKING), ('patrol round', DOCKED, UNDOCKING),
    ('dock', 'Stopped', TO_DOCK)])
@pytest.mark.parametrize('ran', ['Going to 12', UNDOCKING, 'Undocking', TO_DOCK, 'Docking',
                                 'Going to -597 -5765', 'something unknown'])
def test_a_drive_that_somebody_stops_before_the_robot_acknowledges_it_is_over_once_it_stands(
        talk, text, before, sign, ran):
    drive = setting_out(talk, before, text, sign)
    talk.robot(UNDOCKED, f'Interrupted: {ran}', 'Stopping')
    assert drive.result is None
    talk.robot('Stopped')
    assert outcome(drive) is Outcome.INTERRUPTED
    assert drive.result.words == f'Interrupted: {ran}'


def test_such_a_drive_is_over_as_well_if_the_robot_does_not_say_that_it_stands(talk):
    goto = setting_out(talk)
    talk.robot('Interrupted: Undocking', 'Stopping')
    shows(talk, 'Stopped', 4.5)
    assert goto.result is None
    shows(talk, 'Stopped', 6.0)
    assert outcome(goto) is Outcome.INTERRUPTED


def test_an_interruption_after_which_the_robot_leaves_its_dock_was_of_another_drive(talk):
    goto = setting_out(talk)
    talk.robot('Interrupted: Undocking', UNDOCKING, UNDOCKED, 'Stopping', 'Stopped')
    shows(talk, 'Stopped', 15.0)
    assert goto.result is None
    talk.robot('Going to 12')
    assert talk.has_begun(goto)


def test_undocking_that_ends_with_stopping_and_stopped_is_no_stop_of_somebody(talk):
    goto = setting_out(talk)
    talk.robot(UNDOCKED, 'Stopping', 'Stopped')
    shows(talk, 'Stopped', 30.0)
    assert goto.result is None
    talk.robot('Going to 12')
    assert talk.has_begun(goto)


def test_a_robot_that_left_its_dock_before_is_interrupted_in_that_not_in_the_drive(talk):
    goto = setting_out(talk, before=UNDOCKING)
    talk.robot('Interrupted: Undocking', UNDOCKED, 'Stopping', 'Stopped')
    shows(talk, 'Stopped', 15.0)
    assert goto.result is None


def test_a_docking_state_of_a_robot_that_stands_is_no_sign_that_it_sets_out(talk):
    goto = setting_out(talk, before='Stopped', sign=UNDOCKED)
    talk.robot('Interrupted: something unknown', 'Stopping', 'Stopped')
    shows(talk, 'Stopped', 15.0)
    assert goto.result is None


@pytest.mark.parametrize('state', ['Docking', 'Docked'])
def test_a_robot_that_leaves_its_dock_and_is_in_it_again_was_interrupted(talk, state):
    undock = begun(talk, 'undock', UNDOCKING)
    talk.robot(f'DockingState: {state} ForcedState: Unforced ChargeState: Not')
    assert outcome(undock) is Outcome.INTERRUPTED


# --- the tables -----------------------------------------------------------------------------------

def sight(talk: Conversation, command: str, lines: Tuple[str, ...], status: str,
          before: str = 'Stopped') -> Tuple[bool, Optional[Outcome], float]:
    """Returns whether a drive has begun, how it seems to end, and when it was last confirmed."""
    shows(talk, before, 1.5)
    execution = talk.give(command)
    talk.robot(*lines)
    shows(talk, status, 1.5)
    doubt, heard = talk.doubt_of(execution), execution.progress.heard
    return talk.has_begun(execution), doubt and doubt.outcome, heard


ON = ('Going to 12',)
POINT = 'Status: Going to 100 200 StateOfCharge: 79.4 Location: 1 2 3 Temperature: 36'
SIGHTS = {
    'emergency stop': ('goto 12', ON, 'EStop pressed'),
    'no power': ('goto 12', ON, 'Motors disabled'),
    'arrived': ('goto 12', ON, 'Arrived at 12'),
    'its goal': ('goto 12', ON, 'Going to 12'),
    'its point': ('goto 12', ON, 'Going to 100 200'),
    'at its point': ('goto 12', (*ON, POINT), 'Arrived at 100 200'),
    'broken off': ('goto 12', (UNDOCKING,), 'Interrupted: Undocking', DOCKED),
    'on its way to the dock': ('dock', (), 'Going to Dock1'),
    'leaving the dock': ('goto 12', (UNDOCKING,), UNDOCKING, DOCKED)}


def test_each_judgement_has_a_sight():
    assert list(SIGHTS) == [row.name for row in judgements.JUDGEMENTS]


@pytest.mark.parametrize('row', judgements.JUDGEMENTS, ids=lambda row: row.name)
def test_a_judgement_decides_and_nothing_else_stands_for_it(row, monkeypatch):
    begun, doubted, heard = expected = sight(Conversation(), *SIGHTS[row.name])
    if isinstance(row.verdict, Outcome):
        assert doubted is row.verdict
    else:
        assert (doubted, heard > 2.0) == (None, True)
    monkeypatch.setattr(judgements, 'JUDGEMENTS',
                        tuple(one for one in judgements.JUDGEMENTS if one is not row))
    assert sight(Conversation(), *SIGHTS[row.name]) != expected


BEGUN = {DriveCourse.TO_A_PLACE: ('gotoPoint 1 2', ('Going to point',)),
         DriveCourse.INTO_THE_DOCK: ('dock', (DOCK[1],)),
         DriveCourse.OUT_OF_THE_DOCK: ('undock', (UNDOCKING,)),
         DriveCourse.OF_TASKS: ('doTask wait 9', ('Doing task wait 9',))}
KINDS = ActivityKind
TEXTS = {
    KINDS.STOPPED: 'Stopped', KINDS.STOPPING: 'Stopping', KINDS.GOING_TO_GOAL: 'Going to 77',
    KINDS.ARRIVED_AT_GOAL: 'Arrived at 77', KINDS.GOING_TO_POINT: 'Going to 100 200',
    KINDS.ARRIVED_AT_POINT: 'Arrived at 100 200', KINDS.FAILED: 'Failed going to 77',
    KINDS.INTERRUPTED: 'Interrupted: Going to 77', KINDS.PATROLLING: 'Patrolling route r',
    KINDS.DOING_TASK: 'Doing task wait 8', KINDS.DOCKING: 'Docking', KINDS.DOCKED: 'Docked',
    KINDS.UNDOCKING: 'Undocking', KINDS.UNDOCKED: 'Undocked', KINDS.PARKING: 'Parking',
    KINDS.PARKED: 'Parked', KINDS.TELEOPERATED: 'Teleop driving', KINDS.LOST: 'Robot lost'}


@pytest.mark.parametrize(('course', 'kind'), [
    (course, kind) for course, verdicts in judgements.VERDICTS.items() for kind in verdicts])
def test_an_activity_says_this_about_a_drive_that_has_begun(course, kind, monkeypatch):
    verdict = judgements.VERDICTS[course][kind]
    begun, doubted, heard = expected = sight(Conversation(), *BEGUN[course], TEXTS[kind])
    assert begun
    assert doubted is (verdict if isinstance(verdict, Outcome) else None)
    monkeypatch.delitem(judgements.VERDICTS[course], kind)
    assert sight(Conversation(), *BEGUN[course], TEXTS[kind]) != expected
