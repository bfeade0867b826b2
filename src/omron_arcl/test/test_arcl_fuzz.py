"""No input causes an exception or needs unbounded memory, and no good line is lost with a bad one.

1,200 examples by default, 400,000 with LD90_LONG_TESTS=1, divided among the properties.
"""
from __future__ import annotations

import os
import socket
import sys
from typing import List, Sequence

import pytest
from arcl_builders import LOGIN, PASSWORD, STATUS, Conversation, lines, logged_in, texts
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from omron_arcl import (
    COMMANDS,
    ActivityKind,
    InvalidCommand,
    Listener,
    Outcome,
    Reply,
    StatusAssembler,
    parse_command,
    parse_line,
    read_activity,
)
from omron_arcl.command_line import LONGEST_COMMAND
from omron_arcl.framing import LineBuffer, decode
from omron_arcl.parser import _TABLE
from omron_arcl.session import Closed, Session, SessionState

EXAMPLES = 20 * settings.default.max_examples  # examples in a batch; a batch is kept in memory
BATCHES = 40 if os.environ.get('LD90_LONG_TESTS') == '1' else 1


@pytest.fixture(params=range(BATCHES))
def batch(request) -> int:
    return request.param


def share(percent: int):
    """Decorates a property so that it gets this percentage of all examples."""
    def decorate(test):
        few = settings(max_examples=EXAMPLES * percent // 100, database=None,
                       suppress_health_check=list(HealthCheck))
        return pytest.mark.usefixtures('batch')(few(test))
    return decorate


# hypothesis draws a fixed number of bytes in one step; to draw lists of lines takes twenty times as
# long. So each example is one block of bytes, from which `lines_of` makes lines: for each line it
# reads a kind, a beginning, a length, and then the text.
MOST_LINES, MOST_BYTES = 12, 40
BLOB = st.binary(min_size=1 + MOST_LINES * (3 + MOST_BYTES),
                 max_size=1 + MOST_LINES * (3 + MOST_BYTES))
SIZES = st.binary(min_size=30, max_size=30).map(lambda data: [1 + byte % 20 for byte in data])
GOOD = (*STATUS, b'Arrived at 12', b'DockingState: Docked ForcedState: Unforced ChargeState: Float',
        b'RangeDeviceGetCurrent: Laser_1 1 2 3 4')
HEADS = tuple(phrase.encode() for phrase, _ in _TABLE)
ALPHABETS = tuple(bytes(alphabet[i % len(alphabet)] for i in range(256)) for alphabet in (
    bytes(range(256)), bytes(range(32, 127)), b'0123456789 -.',
    b'\xff\xfb\xfd\xfe\x00\t\x7f\xc3\xa9":,_eE+- 0'))


def lines_of(blob: bytes, good: Sequence[bytes] = GOOD) -> List[bytes]:
    """Returns good lines, lines with a known beginning and a random rest, and random bytes."""
    said, at = [], 1
    for _ in range(blob[0] % (MOST_LINES + 1)):
        kind, which, length = blob[at:at + 3]
        at += 3 + length % MOST_BYTES
        noise = blob[at - length % MOST_BYTES:at].translate(ALPHABETS[kind % 4])
        noise = noise.replace(b'\r', b'').replace(b'\n', b'')
        said.append((good[which % len(good)], noise, HEADS[which % len(HEADS)] + b' ' + noise,
                     HEADS[which % len(HEADS)] + noise)[kind // 4 % 4])
    return said


def cut(data: bytes, sizes: Sequence[int]) -> List[bytes]:
    """Returns `data` in pieces of these sizes; the last piece is the rest."""
    pieces, start = [], 0
    for size in sizes:
        pieces.append(data[start:start + size])
        start += size
    return [*pieces, data[start:]]


@share(15)
@given(BLOB)
def test_any_line_is_some_reply(blob):
    for line in lines_of(blob):
        assert isinstance(parse_line(decode(line)), Reply)
        assert isinstance(parse_line(line.decode('latin-1')), Reply)
        assert isinstance(read_activity(decode(line)).kind, ActivityKind)


@share(10)
@given(st.sampled_from(['', *(phrase + ' ' for phrase, _ in _TABLE)]), st.text(max_size=40))
def test_any_text_is_some_reply(head, text):
    assert isinstance(parse_line(head + text), Reply)


@share(20)
@given(BLOB, SIZES)
def test_good_lines_come_out_between_bad_ones_however_they_are_cut(blob, sizes):
    said = lines_of(blob)
    session = Session(None)
    events = [event for piece in cut(lines(*said), sizes) for event in session.receive(piece)]
    good = [line for line in said if line in GOOD]
    assert [event.raw for event in events if event.raw in GOOD] == good
    assert len(events) <= len(said)
    assert session.state is SessionState.READY


@share(10)
@given(BLOB, SIZES, st.booleans())
def test_a_login_takes_any_bytes(blob, sizes, as_lines):
    session = Session(PASSWORD)
    data = lines(*lines_of(blob, LOGIN)) if as_lines else blob
    events = [event for piece in cut(data, sizes) for event in session.receive(piece)]
    events += session.receive_eof()
    assert isinstance(events[-1], Closed)
    assert PASSWORD.decode() not in repr(events)


@share(10)
@given(BLOB, st.sampled_from(range(len(LOGIN))))
def test_noise_in_the_login_never_raises(blob, at):
    session = Session(PASSWORD)
    session.receive(lines(*LOGIN[:at], *lines_of(blob), *LOGIN[at:], *STATUS))
    assert session.state in (SessionState.READY, SessionState.CLOSED)


@share(10)
@given(BLOB, SIZES, st.integers(1, 200))
def test_memory_is_bounded_by_the_longest_line(blob, sizes, limit):
    buffer = LineBuffer(limit)
    for piece in cut(blob, [size * size for size in sizes]):
        for line in buffer.feed(piece):
            assert len(line) <= limit
        assert sys.getsizeof(buffer._tail) <= limit + len(piece) + 200


NAMES = sorted(COMMANDS)
ABOUT_COMMANDS = (
    'Going to 1', 'Arrived at 1', 'Going to point', 'Arrived at point', 'Failed going to 1',
    'Stopping', 'Stopped', 'Interrupted: Going to 1', 'Error: Failed going to goal',
    'EStop pressed', 'Motors disabled', 'Motors enabled', 'CommandError: goto 1',
    "CommandErrorDescription: No goal '1'", 'CommandError: stop', 'Unknown command stop',
    'SetUpError: no', 'Patrolling route 1', 'Doing task 1', 'Completed doing task 1',
    *(f'DockingState: {state} ForcedState: Unforced ChargeState: Not'
      for state in ('Docked', 'Undocking', 'Undocked', 'Docking')),
    'Status: Going to 1 StateOfCharge: 79.4 Location: 1 2 3 Temperature: 36', 'Goal: 1',
    'End of goals', 'Temperature: 36', *(f'{head} 1' for head, _ in _TABLE))


class History:
    """Gives and cancels commands, plays lines, waits and loses the link, as `script` says."""

    def __init__(self, script: bytes) -> None:
        self.talk, self.given, self.ends = Conversation(), [], []
        for what, which in zip(script[::2], script[1::2]):
            if what < 70:
                self.give('stop' if what < 20 else NAMES[which % len(NAMES)])
            elif what < 100 and self.given:
                self.talk.cancel(self.given[which % len(self.given)])
            elif what < 110:
                self.talk.pass_time(which / 10.0)
            elif what < 112:
                self.talk.dispatcher.on_lost('lost')
            else:
                self.talk.robot(ABOUT_COMMANDS[which % len(ABOUT_COMMANDS)])
            self.talk.send()

    def give(self, name: str) -> None:
        text = ' '.join([name, *['1'] * COMMANDS[name].required])
        self.given.append(self.talk.give(text, on_end=self.ends.append))


SCRIPT = st.binary(min_size=80, max_size=80)


@share(10)
@given(SCRIPT)
def test_commands_end_once_whatever_the_robot_says(script):
    history = History(script)
    history.talk.dispatcher.on_lost('over')
    history.talk.tell()
    assert len(history.ends) == len(history.given)
    assert all(execution.result for execution in history.given)


@share(5)
@given(SCRIPT)
@example(bytes(12) + b'\x14\x00' * 2 + bytes(2) + b'\x14\x00' * 4 + bytes(2) + b'\x14\x00' * 11
         + b'\x14\xcb' + bytes(6) + b'\x14\x00' * 2 + bytes(6) + b'\x14\x00\x14\x14\x14'
         + bytes(7))  # a status is on its way, and a drive is not answered
def test_whatever_was_before_a_stop_and_then_a_goto_are_carried_out(script):
    talk = History(script).talk
    stop = talk.give('stop')
    for _ in [e for e in talk.dispatcher._commands.sent if e.command.name == 'stop']:
        talk.robot('Stopping', 'Stopped')
    # the robot may still have to answer an older drive, and the first status may answer an older
    # query
    for _ in range(4):
        talk.pass_time(1.5)
        talk.robot('Status: Stopped StateOfCharge: 79.4 Location: 1 2 3 Temperature: 36')
    talk.pass_time(0.1)
    assert stop.result.outcome is Outcome.SUCCEEDED
    goto = talk.give('goto afterwards')
    talk.robot('Going to afterwards', 'Arrived at afterwards')
    assert goto.result.outcome is Outcome.SUCCEEDED
    assert not [e for e in talk.dispatcher._commands.sent if e.command.spec.drives]


@share(5)
@given(BLOB)
def test_a_status_never_holds_more_than_was_said(blob):
    said = lines_of(blob)
    assembler = StatusAssembler()
    whole = [assembler.add(parse_line(line.decode('utf-8', 'replace'))) for line in said]
    assert sum(status is not None for status in whole) <= len(said)


@share(4)
@given(st.text(max_size=60))
def test_a_command_is_one_line_or_refused(text):
    try:
        sent = parse_command(text).line
    except InvalidCommand as refused:
        assert str(refused).isprintable()
        return
    assert sent.decode('ascii').isprintable()
    assert 0 < len(sent) <= LONGEST_COMMAND


@share(1)
@given(BLOB, SIZES)
def test_a_listener_keeps_the_good_lines(blob, sizes):
    """The test uses a real connection, because the kernel also splits the bytes."""
    said = lines_of(blob)
    received = []
    with Listener('127.0.0.1', 0, '127.0.0.1',
                  on_line=lambda line: received.append(line.raw)) as listener, \
            socket.create_connection(('127.0.0.1', listener.port)) as robot:
        for piece in cut(lines(*said, b'Stopped'), sizes[:5]):
            robot.sendall(piece)
        robot.shutdown(socket.SHUT_WR)
        while robot.recv(100):
            pass  # waits until the listener has read everything and closed
    assert [line for line in received if line in GOOD] == [line for line in said if line in GOOD]
    assert received[-1] == b'Stopped'


def test_a_flood_of_twenty_megabytes_of_garbage_leaves_the_session_small_and_sane():
    session = logged_in()
    garbage = bytes(range(256)) * 256
    for _ in range(20 * 16):
        session.receive(garbage)
    assert session.state is SessionState.READY
    assert len(session._lines._tail) < 1000
    assert texts(session.receive(b'\n' + lines(b'Stopped')))[-1] == 'Stopped'
