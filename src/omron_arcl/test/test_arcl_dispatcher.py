"""Several commands at once: some wait, or are replaced, stopped, cancelled or lost."""
from __future__ import annotations

import pytest
from arcl_builders import DOCK, UNDOCK, UNDOCKED, Conversation, Noted, outcome

from omron_arcl import Busy, Outcome, parse_command
from omron_arcl.command_queue import MAXIMUM_WAITING


@pytest.fixture
def talk() -> Conversation:
    return Conversation()


# --- several at once ------------------------------------------------------------------------------

def test_a_second_goto_interrupts_the_first(talk):
    first, second = talk.give('goto A'), talk.give('goto B')
    talk.robot('Going to A', 'Interrupted: Going to A', 'Going to B')
    assert outcome(first) is Outcome.INTERRUPTED
    assert second.result is None
    talk.robot('Arrived at B')
    assert outcome(second) is Outcome.SUCCEEDED


def test_a_second_goto_replaces_the_first_also_without_a_word(talk):
    first, second = talk.give('goto A'), talk.give('goto B')
    talk.robot('Going to A', 'Going to B')
    assert outcome(first) is Outcome.INTERRUPTED
    assert 'goto B' in first.result.words
    talk.robot('Arrived at B')
    assert outcome(second) is Outcome.SUCCEEDED


@pytest.mark.parametrize('lines', [
    ('Going to point', 'Interrupted: Going to point', 'Going to point', 'Arrived at point'),
    ('Going to point', 'Going to point', 'Arrived at point'),
])
def test_two_points_are_told_apart_by_their_order(talk, lines):
    first, second = talk.give('gotoPoint 1 1'), talk.give('gotoPoint 2 2')
    talk.robot(*lines)
    assert outcome(first) is Outcome.INTERRUPTED
    assert outcome(second) is Outcome.SUCCEEDED


def test_a_point_that_the_robot_names_by_its_coordinates_is_interrupted_by_name(talk):
    goto = talk.give('gotoPoint -597 -5765')
    talk.robot('Going to point', 'Interrupted: Going to -597 -5765')
    assert outcome(goto) is Outcome.INTERRUPTED


@pytest.mark.parametrize('goal', ['-597', '-597 5765', '-597 -5765 90'])
def test_a_goal_whose_name_begins_as_the_point_does_is_another_matter(talk, goal):
    goto = talk.give('gotoPoint -597 -5765')
    talk.robot('Going to point', f'Going to {goal}')
    assert goto.result.words == f'taken over: Going to {goal}'


def test_an_arrival_just_before_the_next_point_belongs_to_the_first(talk):
    first = talk.give('gotoPoint 1 1')
    talk.robot('Going to point')
    second = talk.give('gotoPoint 2 2')
    talk.robot('Arrived at point')
    assert outcome(first) is Outcome.SUCCEEDED
    assert second.result is None
    talk.robot('Going to point', 'Arrived at point')
    assert outcome(second) is Outcome.SUCCEEDED


def test_a_refused_goto_leaves_the_running_one_alone(talk):
    running = talk.give('goto A')
    talk.robot('Going to A')
    refused = talk.give('goto nowhere')
    talk.robot('CommandError: goto nowhere', 'EStop relieved but motors still disabled',
               "CommandErrorDescription: No goal    'nowhere'")
    assert outcome(refused) is Outcome.NO_GOAL
    assert running.result is None


def test_a_refused_command_ends_also_without_a_description(talk):
    refused = talk.give('goto nowhere')
    talk.robot('CommandError: goto nowhere')
    talk.pass_time(1.5)
    assert outcome(refused) is Outcome.REJECTED


def test_a_refused_command_is_known_again_though_its_password_is_blanked(talk):
    add = talk.give('configAdd Password secret')
    talk.robot('CommandError: configAdd Password ********', 'CommandErrorDescription: not enabled')
    assert outcome(add) is Outcome.REJECTED


def test_another_reason_than_the_goal_is_a_rejection(talk):
    refused = talk.give('patrol r')
    talk.robot('CommandError: patrol r', 'CommandErrorDescription: Bad route')
    assert outcome(refused) is Outcome.REJECTED
    assert refused.result.words == 'Bad route'


def test_a_long_unknown_name_is_known_by_its_beginning(talk):
    unknown = talk.give('someVeryLongCommandName 1')
    talk.robot('Unknown command someVeryLongComm')
    assert outcome(unknown) is Outcome.UNKNOWN_COMMAND


def test_a_setup_error_rejects_the_oldest_that_has_not_begun(talk):
    goto = talk.give('goto A')
    talk.robot('Going to A')
    add = talk.give('listAdd move 1')
    talk.robot('SetUpError: You need to start a list before you can add to it.')
    assert outcome(add) is Outcome.REJECTED
    assert goto.result is None


def test_an_emergency_stop_fails_the_enabling_of_motors(talk):
    enable = talk.give('enableMotors')
    talk.robot('Estop pressed, cannot enable motors')
    assert outcome(enable) is Outcome.EMERGENCY_STOPPED


def test_equal_queries_wait_for_each_other(talk):
    first, second, other = (talk.give(text) for text in ('getGoals', 'getGoals', 'odometer'))
    assert talk.sent == ['getGoals', 'odometer']
    talk.robot('Goal: 1', 'Odometer: 1 mm 2 deg 3 sec', 'End of goals')
    assert outcome(first) is Outcome.SUCCEEDED
    assert first.result.lines == ('Goal: 1', 'End of goals')
    assert outcome(other) is Outcome.SUCCEEDED
    assert talk.sent == ['getGoals', 'odometer', 'getGoals']
    talk.robot('Goal: 2', 'End of goals')
    assert second.result.lines == ('Goal: 2', 'End of goals')


def test_a_query_that_is_not_answered_times_out_and_lets_the_next_one_go(talk):
    first, second = talk.give('getGoals'), talk.give('getGoals')
    talk.pass_time(6.0)
    assert outcome(first) is Outcome.TIMED_OUT
    assert second.sent


def test_an_event_answers_the_query_and_still_reaches_the_drive(talk):
    query, dock = talk.give('queryDockStatus'), talk.give('dock')
    talk.robot(DOCK[1])
    assert outcome(query) is Outcome.SUCCEEDED
    assert talk.has_begun(dock)


def test_an_answer_of_unknown_length_ends_when_the_robot_is_quiet(talk):
    unknown = talk.give('arclStat')
    talk.robot('clients 3', 'Going to 12', 'bytes 4')
    talk.pass_time(0.5)
    assert unknown.result is None
    talk.pass_time(1.0)
    assert outcome(unknown) is Outcome.SUCCEEDED
    assert unknown.result.lines == ('clients 3', 'bytes 4')


# --- stop, cancel, lost ---------------------------------------------------------------------------

def test_a_stop_overtakes_what_is_unsent_and_drops_the_drives(talk):
    dispatcher = talk.dispatcher
    goto = talk.give('goto A')

    unsent = dispatcher.start(parse_command('goto B'))
    query = dispatcher.start(parse_command('odometer'))
    dispatcher.start(parse_command('stop'))
    talk.send()
    assert talk.sent == ['goto A', 'stop', 'odometer']
    assert outcome(unsent) is Outcome.CANCELLED
    assert 'never sent' in unsent.result.words
    assert goto.result is None
    assert query.sent


def test_cancelling_a_drive_stops_the_robot(talk):
    goto = talk.give('goto A')
    talk.robot('Going to A')
    talk.cancel(goto)
    talk.send()
    assert talk.sent == ['goto A', 'stop']
    assert goto.result is None, 'the robot has not stopped yet'
    talk.robot('Interrupted: Going to A', 'Stopping', 'Stopped')
    assert outcome(goto) is Outcome.CANCELLED


def test_a_stop_that_is_cancelled_before_it_was_sent_is_sent_all_the_same(talk):
    dispatcher = talk.dispatcher
    stop = dispatcher.start(parse_command('stop'))
    talk.cancel(stop)
    assert outcome(stop) is Outcome.CANCELLED
    talk.send()
    assert talk.sent == ['stop']
    talk.robot('Stopped')


def test_cancelling_docking_ends_when_the_robot_has_stopped(talk):
    dock = talk.give('dock')
    talk.robot(*DOCK[:2])
    talk.cancel(dock)
    talk.send()
    talk.robot('Stopping', 'Stopped')
    assert outcome(dock) is Outcome.CANCELLED


def test_a_drive_given_after_a_stop_is_not_ended_by_the_stop(talk):
    first = talk.give('goto A')
    talk.robot('Going to A')
    talk.give('stop')
    second = talk.give('goto B')
    talk.robot('Interrupted: Going to A', 'Stopping', 'Stopped')
    assert outcome(first) is Outcome.INTERRUPTED
    assert second.result is None
    talk.robot('Going to B', 'Arrived at B')
    assert outcome(second) is Outcome.SUCCEEDED


def test_a_cancelled_drive_does_not_wait_for_ever_for_a_robot_that_ignores_the_stop(talk):
    goto = talk.give('goto A')
    talk.robot('Going to A')
    talk.cancel(goto)
    talk.send()
    talk.pass_time(20.0)
    assert outcome(goto) is Outcome.TIMED_OUT
    assert 'stop' in goto.result.words


@pytest.mark.parametrize(('said', 'expected'), [
    (('Unknown command stop',), Outcome.UNKNOWN_COMMAND),
    (('CommandError: stop', 'CommandErrorDescription: not now'), Outcome.REJECTED),
])
def test_a_cancelled_drive_does_not_wait_for_a_stop_that_the_robot_refused(talk, said, expected):
    goto = talk.give('goto A')
    talk.robot('Going to A')
    talk.cancel(goto)
    talk.send()
    talk.robot(*said)
    assert outcome(goto) is expected


FAILURE = ('Going to A', 'Error: Failed going to goal')


def test_after_a_failed_drive_stop_and_goto_work_as_ever(talk):
    talk.give('goto A')
    talk.robot(*FAILURE)
    stop = talk.give('stop')
    talk.robot('Stopping', 'Stopped')
    assert outcome(stop) is Outcome.SUCCEEDED
    again = talk.give('goto A')
    talk.robot('Going to A', 'Arrived at A')
    assert outcome(again) is Outcome.SUCCEEDED


def test_two_stops_for_one_failed_drive_end_with_one_stopped(talk):
    """A robot that still brakes when the second stop arrives sends only one `Stopped`."""
    talk.give('goto A')
    talk.robot(*FAILURE)
    stops = [talk.give('stop'), talk.give('stop')]
    talk.robot('Stopping', 'Stopping', 'Stopped')
    assert [outcome(stop) for stop in stops] == [Outcome.SUCCEEDED] * 2


def test_a_stopped_does_not_end_the_stop_of_a_later_drive(talk):
    talk.give('goto A')
    talk.robot('Going to A')
    first, later, second = talk.give('stop'), talk.give('goto B'), talk.give('stop')
    talk.robot('Interrupted: Going to A', 'Stopping', 'Stopped')
    assert outcome(first) is Outcome.SUCCEEDED
    assert later.result is None
    assert second.result is None
    talk.robot('Going to B', 'Interrupted: Going to B', 'Stopping', 'Stopped')
    assert outcome(later) is Outcome.INTERRUPTED
    assert outcome(second) is Outcome.SUCCEEDED


def test_a_drive_that_begins_while_the_robot_still_brakes_ends_the_stop(talk):
    """After such a drive has begun, the robot never sends `Stopped` for the stop."""
    talk.give('goto A')
    talk.robot(*FAILURE)
    stop, later = talk.give('stop'), talk.give('goto B')
    talk.robot('Stopping', 'Going to B')
    assert outcome(stop) is Outcome.INTERRUPTED
    assert 'goto B' in stop.result.words
    talk.robot('Arrived at B')
    assert outcome(later) is Outcome.SUCCEEDED


# We stop the robot, but another client drives it before it stands. So it never sends `Stopped`.
OVERTAKEN = ('Interrupted: Going to A', 'Stopping', 'Going to B')


def test_a_stop_that_another_clients_drive_overtakes_ends_at_once_and_not_as_a_success(talk):
    goto = talk.give('goto A')
    talk.robot('Going to A')
    stop = talk.give('stop')
    talk.robot(*OVERTAKEN)
    assert outcome(goto) is Outcome.INTERRUPTED
    assert goto.result.words == 'Interrupted: Going to A'
    assert outcome(stop) is Outcome.INTERRUPTED, 'the robot drives, so the stop has failed'
    assert stop.result.words == 'taken over: Going to B'
    assert stop.result.lines == OVERTAKEN[:2]
    talk.robot('Arrived at B')
    assert talk.sent == ['goto A', 'stop'], 'nothing may be sent again'


def test_a_cancelled_drive_is_over_when_another_clients_drive_overtakes_its_stop(talk):
    goto = talk.give('goto A')
    talk.robot('Going to A')
    talk.cancel(goto)
    talk.send()
    talk.robot('Stopping', 'Going to B')
    assert outcome(goto) is Outcome.CANCELLED
    assert goto.result.words == 'taken over: Going to B'
    assert talk.sent == ['goto A', 'stop']


def test_a_stopped_docking_takes_no_other_drive_for_its_own(talk):
    """A docking robot may name its goal. But after a stop, such a line is about another drive."""
    dock = talk.give('dock')
    talk.robot(*DOCK[:2])
    talk.cancel(dock)
    talk.send()
    talk.robot('Stopping', 'Going to B')
    assert outcome(dock) is Outcome.CANCELLED
    assert not talk.dispatcher._commands.sent


def test_every_stop_that_the_robot_obeyed_is_overtaken(talk):
    talk.give('goto A')
    talk.robot('Going to A')
    obeyed, too, unread = talk.give('stop'), talk.give('stop'), talk.give('stop')
    talk.robot('Interrupted: Going to A', 'Stopping', 'Stopping', 'Going to B')
    assert outcome(obeyed) is Outcome.INTERRUPTED
    assert outcome(too) is Outcome.INTERRUPTED
    assert unread.result is None
    talk.robot('Interrupted: Going to B', 'Stopping', 'Stopped')
    assert outcome(unread) is Outcome.SUCCEEDED


def test_a_stop_that_the_robot_may_not_have_read_yet_waits_for_what_it_does(talk):
    """The other client's drive interrupted our drive. Our stop will interrupt the other drive."""
    talk.give('goto A')
    talk.robot('Going to A')
    stop = talk.give('stop')
    talk.robot('Interrupted: Going to A', 'Going to B')
    assert stop.result is None
    talk.robot('Interrupted: Going to B', 'Stopping', 'Stopped')
    assert outcome(stop) is Outcome.SUCCEEDED


def test_the_halt_after_undocking_is_not_that_of_a_stop_behind_an_unanswered_drive(talk):
    undock = talk.give('undock')
    talk.robot(*UNDOCK[:-2])
    assert outcome(undock) is Outcome.SUCCEEDED
    talk.give('goto 12')
    stop = talk.give('stop')
    talk.robot(*UNDOCK[-2:], 'Going to 9')
    assert stop.result is None, 'the robot has not answered it'
    talk.robot('Going to 12', 'Stopping', 'Stopped')
    assert outcome(stop) is Outcome.SUCCEEDED


def test_a_drive_of_ours_given_after_the_stop_is_not_ended_by_another_clients(talk):
    talk.give('goto A')
    talk.robot('Going to A')
    stop, later = talk.give('stop'), talk.give('goto C')
    talk.robot(*OVERTAKEN)
    assert outcome(stop) is Outcome.INTERRUPTED
    assert later.result is None
    talk.robot('Interrupted: Going to B', 'Going to C', 'Arrived at C')
    assert outcome(later) is Outcome.SUCCEEDED


def test_a_stop_is_overtaken_by_docking_which_only_the_docking_state_tells(talk):
    talk.robot(UNDOCKED)
    stop = talk.give('stop')
    talk.robot('Stopping', UNDOCKED)
    assert stop.result is None
    talk.robot(DOCK[1])
    assert outcome(stop) is Outcome.INTERRUPTED


def test_a_charger_that_changes_its_mind_overtakes_no_stop(talk):
    dock = talk.give('dock')
    talk.robot(*DOCK[:2])
    talk.cancel(dock)
    talk.send()
    talk.robot('Interrupted: Docking', 'Stopping', DOCK[2])
    assert outcome(dock) is Outcome.CANCELLED
    assert talk.dispatcher._commands.sent, 'the stop must still wait until the robot stands'


def test_cancelling_a_drive_does_not_drop_the_one_that_waits_to_replace_it(talk):
    first = talk.give('goto A')
    talk.robot('Going to A')
    second = talk.dispatcher.start(parse_command('goto B'))
    talk.cancel(first)
    talk.send()
    assert talk.sent == ['goto A', 'goto B']
    talk.robot('Interrupted: Going to A', 'Going to B', 'Arrived at B')
    assert outcome(first) is Outcome.CANCELLED
    assert outcome(second) is Outcome.SUCCEEDED


def test_a_cancelled_drive_is_stopped_when_the_one_that_waits_is_cancelled_too(talk):
    first = talk.give('goto A')
    talk.robot('Going to A')
    second = talk.dispatcher.start(parse_command('goto B'))
    talk.cancel(first)
    talk.cancel(second)
    talk.send()
    assert talk.sent == ['goto A', 'stop']


def test_a_robot_that_arrived_before_the_stop_has_arrived(talk):
    goto = talk.give('goto A')
    talk.robot('Going to A')
    talk.cancel(goto)
    talk.send()
    talk.robot('Arrived at A', 'Stopping', 'Stopped')
    assert outcome(goto) is Outcome.SUCCEEDED


def test_cancelling_twice_stops_once(talk):
    goto = talk.give('goto A')
    talk.cancel(goto)
    talk.cancel(goto)
    talk.send()
    assert talk.sent == ['goto A', 'stop']


def test_cancelling_a_drive_that_was_replaced_leaves_the_new_one_alone(talk):
    first, second = talk.give('goto A'), talk.give('goto B')
    talk.cancel(first)
    talk.send()
    assert talk.sent == ['goto A', 'goto B']
    talk.robot('Going to A', 'Interrupted: Going to A', 'Going to B', 'Arrived at B')
    assert outcome(first) is Outcome.CANCELLED
    assert outcome(second) is Outcome.SUCCEEDED


def test_a_cancelled_drive_is_stopped_after_all_when_its_replacement_is_refused(talk):
    first = talk.give('goto A')
    talk.robot('Going to A')
    talk.give('goto nowhere')
    talk.cancel(first)
    talk.robot('CommandError: goto nowhere', "CommandErrorDescription: No goal 'nowhere'")
    assert talk.sent[-1] == 'stop'


def test_a_cancelled_query_ends_at_once_and_its_answer_goes_to_nobody(talk):
    first, second = talk.give('getGoals'), talk.give('getGoals')
    talk.cancel(first)
    assert outcome(first) is Outcome.CANCELLED
    talk.send()
    assert talk.sent == ['getGoals']
    talk.robot('Goal: 1', 'End of goals', 'Goal: 2', 'End of goals')
    assert second.result.lines == ('Goal: 2', 'End of goals')


def test_a_lost_link_ends_everything_and_nothing_is_sent_again(talk):
    sent, waiting = talk.give('getGoals'), talk.give('getGoals')
    goto = talk.give('goto A')
    talk.dispatcher.on_lost('the robot is gone')
    assert [outcome(e) for e in (sent, waiting, goto)] == [
        Outcome.LOST, Outcome.NEVER_SENT, Outcome.LOST]
    assert talk.dispatcher.next_to_send(talk.now) is None


def test_no_more_commands_wait_than_is_sound_but_a_stop_always_does(talk):

    for _ in range(MAXIMUM_WAITING):
        talk.dispatcher.start(parse_command('odometer'))
    with pytest.raises(Busy):
        talk.dispatcher.start(parse_command('odometer'))
    talk.dispatcher.start(parse_command('stop'))
    assert talk.dispatcher.next_to_send(0.0) == b'stop'


def test_those_who_wait_are_told_in_order(talk):
    noted = Noted()
    talk.give('goto A', on_line=noted, on_end=lambda result: noted(result.outcome))
    talk.robot('Going to A', 'Arrived at A')
    assert noted.all == ['Going to A', 'Arrived at A', Outcome.SUCCEEDED]


def test_an_answer_that_does_not_end_is_given_up_however_much_comes(talk):
    query = talk.give('getGoals')
    for _ in range(35):
        talk.robot('Goal: 1')
        talk.pass_time(2.0)
    assert outcome(query) is Outcome.TIMED_OUT


def test_a_drive_that_times_out_is_stopped_if_that_was_asked_for(talk):
    goto = talk.give('goto 12', timeout=10.0, stop_on_timeout=True)
    talk.robot('Going to 12')
    talk.pass_time(11.0)
    assert outcome(goto) is Outcome.TIMED_OUT
    assert talk.sent == ['goto 12', 'stop']


def test_an_older_drive_that_times_out_stops_no_newer_one(talk):
    older = talk.give('goto 12', timeout=10.0, stop_on_timeout=True)
    talk.give('goto 13', stop_on_timeout=True)
    talk.pass_time(11.0)
    assert outcome(older) is Outcome.TIMED_OUT
    assert talk.sent == ['goto 12', 'goto 13']


def test_a_cancelled_drive_is_stopped_when_the_newer_one_does_not_replace_it(talk):
    """The robot may have missed the newer drive. The older one must not go on for a minute."""
    older = talk.give('goto 12')
    talk.robot('Going to 12')
    talk.give('goto 13')
    talk.cancel(older)
    talk.pass_time(4.0)
    assert talk.sent == ['goto 12', 'goto 13']
    talk.pass_time(2.0)
    talk.pass_time(2.0)
    assert talk.sent == ['goto 12', 'goto 13', 'stop']


def test_stops_go_out_in_the_order_in_which_they_were_given(talk):
    noted = Noted()
    for number in range(3):
        talk.dispatcher.start(parse_command('stop'), on_end=lambda _, number=number: noted(number))
    talk.send()
    talk.robot('Stopping', 'Stopped')
    assert noted.all == [0, 1, 2]
