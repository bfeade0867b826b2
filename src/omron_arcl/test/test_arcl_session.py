"""The login with its variants, the possible ends of a session, and the secrecy of passwords."""
from __future__ import annotations

from typing import List

import pytest
from arcl_builders import (
    FEEDS,
    HELP_LIST,
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

from omron_arcl import Received, parse_line
from omron_arcl.errors import ConnectionFailed, ConnectionLost, LineTooLong, WrongPassword
from omron_arcl.session import (
    HELP_TIMEOUT,
    PROMPT_TIMEOUT,
    WELCOME_TIMEOUT,
    Closed,
    Event,
    LoggedIn,
    Session,
    SessionState,
)


@pytest.mark.parametrize('feed', FEEDS)
def test_a_session_logs_in_and_reads_the_help_list(feed):
    session = Session(PASSWORD)
    (event,) = feed(session, lines(*LOGIN))
    assert isinstance(event, LoggedIn)
    assert event.help.descriptions['quit'] == 'closes this connection to the server'
    assert len(event.help) == 6
    assert session.state is SessionState.READY
    assert session.pop_output() == b'adept\necho off\n'


def test_the_states_of_the_login_follow_the_robots_lines():
    session = Session(PASSWORD)
    seen = [session.state]
    for line in LOGIN:
        session.receive(lines(line))
        if session.state is not seen[-1]:
            seen.append(session.state)
    assert seen == [SessionState.AWAITING_PROMPT, SessionState.LOGGING_IN,
                    SessionState.DRAINING_HELP_LIST, SessionState.READY]


@pytest.mark.parametrize('prompt', [
    b'Enter password:', b'Enter password: ', b'Password>', b'Please type your PASSWORD?',
    b'password:\r\n', b'Enter password\r\n', b'ARCL 5.4\r\n\r\nEnter password:\r\n'])
def test_whatever_asks_for_a_password_is_a_prompt_with_or_without_a_line_end(prompt):
    for feed in (feed_whole, feed_byte_by_byte):
        session = Session(PASSWORD)
        feed(session, prompt)
        assert session.pop_output() == b'adept\n'
        feed(session, b'\r\n')
        feed(session, lines(*LOGIN[1:]))
        assert session.state is SessionState.READY


def test_a_prompt_is_not_answered_before_it_is_all_there():
    session = Session(PASSWORD)
    for piece in (b'Enter passwor', b'd'):
        session.receive(piece)
        assert session.pop_output() == b''


def after(session: Session, *moments: float) -> List[Event]:
    """Returns the session's events at these moments (s)."""
    return [event for now in moments for event in session.on_time(now)]


@pytest.mark.parametrize('greeting', [b'', b'Robot 7\r\n', b'login>'])
def test_without_a_prompt_the_password_is_sent_after_a_moment(greeting):
    session = Session(PASSWORD)
    session.receive(greeting)
    after(session, 100.0, 100.0 + PROMPT_TIMEOUT - 0.1)
    assert session.pop_output() == b''
    after(session, 100.0 + PROMPT_TIMEOUT)
    assert session.pop_output() == b'adept\n'
    session.receive(b'\r\n' + lines(*LOGIN[1:]))
    assert session.state is SessionState.READY


def test_a_prompt_that_comes_late_is_not_a_refusal():
    session = Session(PASSWORD)
    after(session, 0.0, 2.0)
    session.receive(lines(*LOGIN[:1]))
    assert session.state is SessionState.LOGGING_IN
    session.receive(lines(*LOGIN[1:]))
    assert session.state is SessionState.READY
    assert session.pop_output() == b'adept\necho off\n'


@pytest.mark.parametrize('welcome', [
    (b'Welcome to the server.',), (b'Hello, user.',), (), (b'adept', b'Logged in.')])
def test_any_welcome_or_none_leads_to_the_help_list(welcome):
    session = Session(PASSWORD)
    (event,) = session.receive(lines(LOGIN[0], *welcome, *HELP_LIST))
    assert event.help.full_name('goto') == 'goto'
    assert event.help.complete


def test_without_a_help_list_the_login_ends_when_the_robot_is_quiet():
    session = Session(PASSWORD)
    session.receive(lines(LOGIN[0], b'Welcome.'))
    assert after(session, 0.0, HELP_TIMEOUT - 0.1) == []
    (event,) = after(session, HELP_TIMEOUT)
    assert not event.help.complete
    assert session.state is SessionState.READY


def test_a_help_list_without_its_end_is_taken_as_far_as_it_came():
    session = Session(PASSWORD)
    session.receive(lines(*LOGIN[:-1]))
    (event,) = after(session, 0.0, HELP_TIMEOUT)
    assert event.help.full_name('goto') == 'goto'
    assert not event.help.complete


def test_a_robot_that_never_stops_talking_in_the_login_is_logged_in_all_the_same():
    session = Session(PASSWORD)
    session.receive(lines(*LOGIN[:2]))
    events = []
    for tenth in range(200):
        session.receive(lines(b'Status: Stopped'))
        events += session.on_time(tenth / 10.0)
    assert [type(event) for event in events] == [LoggedIn]


def test_a_robot_that_says_nothing_after_the_password_is_asked_for_a_line():
    session = Session(PASSWORD)
    session.receive(lines(LOGIN[0]))
    after(session, 0.0, WELCOME_TIMEOUT, 2 * WELCOME_TIMEOUT)
    assert session.pop_output() == b'adept\noneLineStatus\n'
    events = session.receive(lines(b'Status: Stopped Location: 1 2 3'))
    assert texts(events) == ['Status: Stopped Location: 1 2 3']
    assert isinstance(after(session, 10.0, 10.0 + HELP_TIMEOUT)[0], LoggedIn)


@pytest.mark.parametrize(('listed', 'name', 'description'), [
    (b'%-28s%s' % (b'goto', b'Goes to a goal'), 'goto', 'Goes to a goal'),
    (b'goto - Goes to a goal', 'goto', '- Goes to a goal'),
    (b'\tgoto\tGoes to a goal', 'goto', 'Goes to a goal'),
    (b'goto', 'goto', ''),
])
def test_a_help_list_of_another_layout_is_read(listed, name, description):
    session = Session(PASSWORD)
    (event,) = session.receive(lines(*LOGIN[:4], listed, b'End of commands'))
    assert event.help.descriptions == {name: description}


@pytest.mark.parametrize('verdict', [
    b'Incorrect password', b'Login failed.', b'Access denied', b'Enter password:',
    b'invalid password, try again'])
def test_a_complaint_after_the_password_is_a_wrong_password(verdict):
    session = Session(PASSWORD)
    cause = closing(session.receive(lines(LOGIN[0], verdict))).cause
    assert isinstance(cause, WrongPassword)


def test_a_failed_login_says_what_was_received_and_not_the_password():
    session = Session(PASSWORD)
    session.receive(lines(b'FTP \x1b[2J server adept ' + b'x' * 500))
    (event,) = session.receive_eof()
    assert r'saying "FTP \x1b[2J server ******** xxx' in str(event.cause)
    assert len(str(event.cause)) < 300


def test_a_server_that_leaves_on_a_password_it_did_not_ask_for_has_not_refused_it():
    session = Session(PASSWORD)
    after(session, 0.0, 2.0)
    cause = closing(session.receive_eof()).cause
    assert isinstance(cause, ConnectionFailed)
    assert 'not asked' in str(cause)


def test_a_session_without_login_speaks_at_once():
    session = Session(None)
    assert session.state is SessionState.READY
    assert texts(session.receive(lines(*STATUS))) == [line.decode() for line in STATUS]
    assert session.pop_output() == b''


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
    (LOGIN[:4], ConnectionLost, 'during the login'),
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
    assert session.state is SessionState.CLOSED


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
    assert event == Received(b'caf\xe9', parse_line('caf\xe9'))
    assert event.text == 'caf\xe9'


def test_a_closed_session_says_nothing_more():
    session = logged_in()
    assert isinstance(session.receive_eof()[0], Closed)
    assert session.receive(lines(b'Stopped')) == []
