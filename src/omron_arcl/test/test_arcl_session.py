"""The login as the robot does it, the ends that a session can have, and what stays secret."""
from __future__ import annotations

import pytest
from arcl_builders import (
    FEEDS,
    LOGIN,
    PASSWORD,
    STATUS,
    Noted,
    closing,
    feed_byte_by_byte,
    feed_whole,
    lines,
    logged_in,
    texts,
)

from omron_arcl import (
    Closed,
    ConnectionFailed,
    ConnectionLost,
    HelpList,
    LineTooLong,
    LoggedIn,
    Received,
    Session,
    State,
    WrongPassword,
    parse_line,
)


@pytest.mark.parametrize('feed', FEEDS)
def test_a_session_logs_in_and_reads_the_help_list(feed):
    session = Session(PASSWORD)
    (event,) = feed(session, lines(*LOGIN))
    assert isinstance(event, LoggedIn)
    assert event.help.descriptions['quit'] == 'closes this connection to the server'
    assert len(event.help) == 6
    assert session.state is State.READY
    assert session.take_output() == b'adept\necho off\n'


def test_the_states_of_the_login_follow_the_robots_lines():
    session = Session(PASSWORD)
    seen = [session.state]
    for line in LOGIN:
        session.receive(lines(line))
        if session.state is not seen[-1]:
            seen.append(session.state)
    assert seen == [State.AWAITING_PROMPT, State.LOGGING_IN, State.DRAINING_HELP_LIST, State.READY]


def test_the_password_waits_for_the_whole_prompt():
    session = Session(PASSWORD)
    session.receive(b'Enter password:')
    assert session.take_output() == b''
    session.receive(b'\r\n')
    assert session.take_output() == b'adept\n'


def test_a_session_without_login_speaks_at_once():
    session = Session(None)
    assert session.state is State.READY
    assert texts(session.receive(lines(*STATUS))) == [line.decode() for line in STATUS]
    assert session.take_output() == b''


@pytest.mark.parametrize('feed', FEEDS)
def test_lines_after_the_login_come_out_exactly_as_received(feed):
    session = logged_in()
    events = feed(session, lines(*STATUS, b'caf\xe9'))
    assert [event.raw for event in events] == [*STATUS, b'caf\xe9']
    assert [event.reply for event in events[:6]] == [parse_line(line.decode()) for line in STATUS]


def test_lines_in_the_piece_that_ends_the_login_are_not_lost():
    events = Session(PASSWORD).receive(lines(*LOGIN, *STATUS))
    assert isinstance(events[0], LoggedIn)
    assert len(events) == 7


def test_an_event_between_two_entries_of_the_help_list_is_not_lost():
    session = Session(PASSWORD)
    events = session.receive(lines(*LOGIN[:5], b'EStop pressed', *LOGIN[5:]))
    assert texts(events) == ['EStop pressed']
    assert isinstance(events[-1], LoggedIn)


def test_words_of_the_help_list_are_no_replies():
    session = Session(PASSWORD)
    assert texts(session.receive(lines(*LOGIN))) == []


@pytest.mark.parametrize(('said', 'cause', 'words'), [
    ((), ConnectionFailed, 'before the login'),
    ((b'Conn refused.', b'Only client allowed and it is already connected.'), ConnectionFailed,
     'Only client allowed'),
    (LOGIN[:1], WrongPassword, 'refused the password'),
    (LOGIN[:4], ConnectionLost, 'in the login'),
    (LOGIN, ConnectionLost, 'closed the connection'),
    ((*LOGIN, b'Shutting down server'), ConnectionLost, 'Shutting down server'),
    ((*LOGIN, b'half a li'), ConnectionLost, 'closed the connection'),
])
def test_the_end_of_the_connection_means_what_the_state_says(said, cause, words):
    session = Session(PASSWORD)
    session.receive(lines(*said))
    (event,) = session.receive_eof()
    assert type(event.cause) is cause
    assert words in str(event.cause)
    assert session.state is State.CLOSED


def test_a_second_prompt_means_a_wrong_password():
    session = Session(PASSWORD)
    events = session.receive(lines(LOGIN[0], LOGIN[0]))
    assert isinstance(closing(events).cause, WrongPassword)


def test_a_help_list_without_end_closes_the_session():
    session = Session(PASSWORD)
    entries = [b'%15s          does it' % f'c{i}'.encode() for i in range(3000)]
    events = session.receive(lines(*LOGIN[:4], *entries))
    assert 'does not end' in str(closing(events).cause)


@pytest.mark.parametrize('feed', [feed_whole, feed_byte_by_byte])
@pytest.mark.parametrize('password', [None, PASSWORD])
def test_a_line_beyond_all_measure_closes_the_session_after_the_good_ones(feed, password):
    session = Session(password, longest_line=1000)
    greeting = lines(*LOGIN) if password else b''
    events = feed(session, greeting + lines(b'Stopped', b'x' * 1001, b'Stopping'))
    assert isinstance(closing(events).cause, LineTooLong)
    assert texts(events) == ['Stopped']
    assert session.receive(b'more\n') == []
    assert session.receive_eof() == []


def test_no_event_holds_the_password():
    session = Session(PASSWORD)
    events = session.receive(lines(LOGIN[0]))
    events += session.receive(b'adept\r\n')  # an echoing server
    events += session.receive(lines(*LOGIN[1:])) + session.receive_eof()
    assert 'adept' not in repr(events)
    assert 'adept' not in str(closing(events).cause)


def test_the_trace_holds_both_sides_without_the_password():
    trace = Noted()
    session = Session(PASSWORD, trace=lambda side, line: trace((side, line)))
    session.receive(lines(LOGIN[0]) + b'adept\r\n' + lines(*LOGIN[1:], *STATUS))
    assert trace.all[:3] == [('S', b'Enter password:'), ('C', b'********'), ('S', b'********')]
    assert ('C', b'echo off') in trace.all
    assert trace.all[-6:] == [('S', line) for line in STATUS]


def test_a_password_in_the_robots_configuration_is_blanked_everywhere():
    trace = Noted()
    session = Session(None, trace=lambda side, line: trace((side, line)))
    events = session.receive(lines(b'GetConfigSectionValue: Password adept',
                                   b"Added 'Password adept' to the config",
                                   b'GetConfigSectionValue: PortNumber 7171',
                                   b'CommandError: configAdd Password adept',
                                   b'configAdd Password adept'))  # an echo
    assert 'adept' not in repr(events) + repr(trace.all)
    assert events[0].raw == b'GetConfigSectionValue: Password ********'
    assert events[1].raw == b"Added 'Password ********' to the config"
    assert events[2].raw == b'GetConfigSectionValue: PortNumber 7171'
    assert events[3].raw == b'CommandError: configAdd Password ********'
    assert events[4].raw == b'configAdd Password ********'


def test_text_is_readable_whatever_the_bytes_are():
    (event,) = Session(None).receive(b'caf\xe9\n')
    assert event == Received(b'caf\xe9', parse_line('caf\ufffd'))
    assert event.text == 'caf\ufffd'


def test_a_help_list_knows_names_without_case_and_shortcuts():
    help_list = HelpList({'applicationFaultQuery': 'Gets the faults [afq]', 'goto': 'Goes'})
    assert help_list.full_name('GOTO') == 'goto'
    assert help_list.full_name('afq') == 'applicationFaultQuery'
    assert help_list.full_name('quit') is None


def test_a_closed_session_says_nothing_more():
    session = logged_in()
    assert isinstance(session.receive_eof()[0], Closed)
    assert session.receive(lines(b'Stopped')) == []
