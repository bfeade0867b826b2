"""Whatever comes: no exception, no unbounded memory, and no good line lost beside a bad one.

5,000 examples by default, 200,000 with LD90_LONG_TESTS=1, shared out among the properties.
"""
from __future__ import annotations

import os
import socket
import sys

import pytest
from arcl_builders import LOGIN, PASSWORD, STATUS, Conversation, lines, logged_in, texts
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from omron_ld90.arcl import (
    COMMANDS,
    Closed,
    Command,
    InvalidCommand,
    Listener,
    Reply,
    Session,
    State,
    StatusAssembler,
    parse_line,
)
from omron_ld90.arcl.commands import LONGEST_COMMAND
from omron_ld90.arcl.framing import LineBuffer
from omron_ld90.arcl.parser import _TABLE

EXAMPLES = 5_000  # in a batch; hypothesis keeps all of a batch in memory
BATCHES = 40 if os.environ.get('LD90_LONG_TESTS') == '1' else 1


@pytest.fixture(params=range(BATCHES))
def batch(request) -> int:
    return request.param


def share(percent: int):
    """A property that gets so many per cent of all examples."""
    def decorate(test):
        few = settings(max_examples=EXAMPLES * percent // 100, deadline=None, database=None,
                       suppress_health_check=list(HealthCheck))
        return pytest.mark.usefixtures('batch')(few(test))
    return decorate


GOOD = st.sampled_from([*STATUS, b'Arrived at 12', b'DockingState: Docked ForcedState: Unforced '
                        b'ChargeState: Float', b'RangeDeviceGetCurrent: Laser_1 1 2 3 4'])
# Lines that begin as the robot's do and go on as they please; and any bytes without a line end.
HEADS = st.sampled_from([phrase for phrase, _ in _TABLE])
SAID = st.builds(lambda head, rest: f'{head} {rest}', HEADS,
                 st.one_of(st.text(max_size=40), st.from_regex(r'-?\d{1,20}( -?\d{1,20}){0,5}')))
NOISE = st.one_of(st.binary(max_size=60),
                  SAID.map(lambda text: text.encode('utf-8', 'replace')))
BAD = NOISE.map(lambda data: data.replace(b'\n', b'').replace(b'\r', b''))
CUTS = st.lists(st.integers(1, 20), max_size=30)


def cut(data: bytes, sizes) -> list:
    """`data` in pieces of these sizes, the rest as the last one."""
    pieces, start = [], 0
    for size in sizes:
        pieces.append(data[start:start + size])
        start += size
    return [*pieces, data[start:]]


@share(30)
@given(st.one_of(st.text(), SAID))
def test_any_line_is_some_reply(text):
    assert isinstance(parse_line(text), Reply)


@share(20)
@given(st.lists(st.one_of(GOOD, BAD), max_size=12), CUTS)
def test_good_lines_come_out_between_bad_ones_however_they_are_cut(said, sizes):
    session = Session(None)
    events = [event for piece in cut(lines(*said), sizes) for event in session.receive(piece)]
    good = [line for line in said if line in STATUS]
    assert [event.raw for event in events if event.raw in STATUS] == good
    assert len(events) <= len(said)
    assert session.state is State.READY


@share(10)
@given(st.lists(st.binary(max_size=200), max_size=10))
def test_a_login_takes_any_bytes(pieces):
    session = Session(PASSWORD)
    events = [event for piece in pieces for event in session.receive(piece)]
    events += session.receive_eof()
    assert isinstance(events[-1], Closed)
    assert PASSWORD.decode() not in repr(events)


@share(10)
@given(st.lists(BAD, max_size=6), st.sampled_from(range(len(LOGIN))))
def test_noise_in_the_login_never_raises(noise, at):
    session = Session(PASSWORD)
    session.receive(lines(*LOGIN[:at], *noise, *LOGIN[at:], *STATUS))
    assert session.state in (State.READY, State.CLOSED)


@share(10)
@given(st.lists(st.binary(min_size=1, max_size=300), max_size=20), st.integers(1, 200))
def test_memory_is_bounded_by_the_longest_line(pieces, limit):
    buffer = LineBuffer(limit)
    for piece in pieces:
        for line in buffer.feed(piece):
            assert len(line) <= limit
        assert sys.getsizeof(buffer._tail) <= limit + len(piece) + 200


@share(10)
@given(st.lists(st.one_of(SAID, st.sampled_from(['Going to 1', 'Arrived at 1', 'Stopped']),
                          st.sampled_from(['give', 'cancel', 'wait', 'lost'])), max_size=30),
       st.lists(st.sampled_from(sorted(COMMANDS)), min_size=1, max_size=6))
def test_commands_end_once_whatever_the_robot_says(said, names):
    talk, ends, given_ = Conversation(), [], []
    names = names * 5

    def give() -> None:
        if names:
            spec = COMMANDS[names.pop()]
            execution = talk.give(' '.join([spec.name, *['1'] * spec.required]),
                                  on_end=lambda result: ends.append(result))
            given_.append(execution)

    actions = {'give': give, 'wait': lambda: talk.pass_time(10.0),
               'cancel': lambda: given_ and talk.dispatcher.cancel(given_[-1]),
               'lost': lambda: talk.dispatcher.on_lost('lost')}
    give()
    for text in said:
        actions.get(text, lambda text=text: talk.robot(text))()
        talk.send()
    talk.dispatcher.on_lost('over')
    talk.tell()
    assert len(ends) == len(given_)
    assert all(execution.result for execution in given_)


@share(5)
@given(st.lists(st.one_of(GOOD, BAD), max_size=40))
def test_a_status_never_holds_more_than_was_said(said):
    assembler = StatusAssembler()
    whole = [assembler.add(parse_line(line.decode('utf-8', 'replace'))) for line in said]
    assert sum(status is not None for status in whole) <= len(said)


@share(4)
@given(st.text(max_size=60))
def test_a_command_is_one_line_or_refused(text):
    try:
        sent = Command.parse(text).text
    except InvalidCommand as refused:
        assert str(refused).isprintable()
        return
    assert sent.isascii()
    assert sent.isprintable()
    assert 0 < len(sent) <= LONGEST_COMMAND


@share(1)
@given(st.lists(st.one_of(GOOD, BAD), max_size=8), st.lists(st.integers(1, 50), max_size=5))
def test_a_listener_keeps_the_good_lines(said, sizes):
    """Over a real connection, for the bytes that the kernel cuts."""
    received = []
    with Listener('127.0.0.1', 0, '127.0.0.1',
                  on_line=lambda line: received.append(line.raw)) as listener, \
            socket.create_connection(('127.0.0.1', listener.port)) as robot:
        for piece in cut(lines(*said, b'Stopped'), sizes):
            robot.sendall(piece)
        robot.shutdown(socket.SHUT_WR)
        while robot.recv(100):
            pass  # until the listener has read all and closed
    assert [line for line in received if line in STATUS] == [line for line in said
                                                             if line in STATUS]
    assert received[-1] == b'Stopped'


def test_a_flood_of_twenty_megabytes_of_garbage_leaves_the_session_small_and_sane():
    session = logged_in()
    garbage = bytes(range(256)) * 256
    for _ in range(20 * 16):
        session.receive(garbage)
    assert session.state is State.READY
    assert len(session._lines._tail) < 1000
    assert texts(session.receive(b'\n' + lines(b'Stopped')))[-1] == 'Stopped'
