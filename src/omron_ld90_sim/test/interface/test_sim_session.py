"""One connection: login, framing and echo, byte by byte and without sockets."""
from __future__ import annotations

import pytest
from sim_builders import Rig

from omron_ld90_sim.interface.commands import TABLE


def test_the_prompt_is_a_whole_line() -> None:
    assert bytes(Rig().server.connect().output) == b'Enter password:\r\n'


@pytest.mark.parametrize('end', [b'\n', b'\r\n', b'\r', b'\r\0'])
def test_every_line_end_is_understood(end: bytes) -> None:
    rig = Rig()
    session = rig.server.connect()
    session.output.clear()
    session.receive(b'adept' + end + b'queryMotors' + end)
    assert bytes(session.output).endswith(b'End of commands\r\nMotors enabled\r\n')


def test_the_welcome_and_the_help_list_are_the_servers() -> None:
    rig = Rig()
    session = rig.server.connect()
    session.output.clear()
    session.receive(b'adept\n')
    lines = session.output.decode().split('\r\n')
    assert lines[:3] == ['Welcome to the server.',
                         "You can type 'help' at any time for the following help list.",
                         'Commands:']
    assert lines[-2:] == ['End of commands', '']
    rows = lines[3:-2]
    assert '           dock          Sends the robot to the dock' in rows
    assert ('applicationFaultQuery          Gets the list of any application faults currently '
            'triggered [afq]') in rows
    names = [row.split()[0].lower() for row in rows]
    assert names == sorted(names) and len(names) == len({row.name for row in TABLE.values()})


@pytest.mark.parametrize('typed', [b'adapt\n', b'adapt\nadept\nqueryMotors\n'])
def test_a_wrong_password_closes_without_a_word(typed: bytes) -> None:
    session = Rig().server.connect()
    session.output.clear()
    session.receive(typed)
    assert session.closed and not session.output


def test_empty_lines_before_the_password_are_ignored() -> None:
    session = Rig().server.connect()
    session.receive(b'\r\n\n  \nadept\n')
    assert b'Welcome to the server.' in session.output


@pytest.mark.parametrize('negotiation', [
    b'\xff\xfb\x1f\xff\xfd\x03',
    # the options that a terminal program sends first: window size, speed, type, environment, echo,
    # no go-ahead
    b'\xff\xfb\x1f\xff\xfb\x20\xff\xfb\x18\xff\xfb\x27\xff\xfd\x01\xff\xfb\x03\xff\xfd\x03'])
def test_telnet_negotiation_is_stripped_from_the_password(negotiation: bytes) -> None:
    together, apart = Rig().server.connect(), Rig().server.connect()
    together.receive(negotiation + b'adept\n')
    apart.receive(negotiation)
    apart.receive(b'adept\r\n')
    for session in (together, apart):
        assert b'Welcome to the server.' in session.output


def test_an_interrupted_telnet_client_goes_on_with_its_next_command() -> None:
    client = Rig().client()
    client.session.receive(b'\xff\xf4\xff\xfd\x06queryMotors\r\n')    # Ctrl-C, then a command
    assert client.lines() == ['Motors enabled']


def test_a_password_may_come_early_and_in_pieces() -> None:
    session = Rig().server.connect()
    for piece in (b'a', b'dep', b't\r', b'\nqueryMotors\r\n'):
        session.receive(piece)
    assert bytes(session.output).startswith(b'Enter password:\r\nWelcome to the server.\r\n')
    assert bytes(session.output).endswith(b'End of commands\r\nMotors enabled\r\n')


def test_what_is_typed_slowly_comes_back_until_its_line_ends() -> None:
    rig = Rig()
    client = rig.client()
    for typed in (b'que', b'ryMotors'):
        client.session.receive(typed)
        assert not client.session.output, 'the server must look only once in a cycle'
        rig.clock.advance(rig.clock.now + 0.1)
        assert bytes(client.session.output) == typed
        client.session.output.clear()
    client.session.receive(b'\r\n')
    assert bytes(client.session.output) == b'\n\rMotors enabled\r\n'


@pytest.mark.parametrize('first', [b'echo off\n', b'echo on\n', b'\xff\xfb\x1fecho\n'])
def test_nothing_typed_comes_back_once_echo_is_set_or_telnet_has_negotiated(first: bytes) -> None:
    rig = Rig()
    client = rig.client()
    client.session.receive(first + b'queryMot')
    client.session.output.clear()
    rig.clock.advance(rig.clock.now + 1.0)
    assert not client.session.output


def test_line_ends_around_a_command_say_nothing() -> None:
    client = Rig().client()
    client.session.receive(b'\r\nqueryMotors\n\n queryDockStatus\r\n\r\n')
    assert client.lines() == ['Motors enabled',
                              'DockingState: Undocked ForcedState: Unforced ChargeState: Not']


def test_replies_to_pipelined_commands_come_whole_and_in_order() -> None:
    client = Rig().client()
    commands = ['getGoals', 'GETMACROS', 'gooto 12', 'goto 99', 'oneLineStatus', 'getroutes']
    one_by_one = [line for command in commands for line in client.ask(command)]
    client.session.receive('\n '.join([*commands, '']).encode())
    assert client.lines() == one_by_one


def test_a_cut_line_is_kept_until_its_end_arrives() -> None:
    client = Rig().client()
    for byte in b'queryMotors':
        client.session.receive(bytes([byte]))
        assert client.lines() == []
    client.session.receive(b'\n')
    assert client.lines() == ['Motors enabled']


def test_several_commands_in_one_segment_are_answered_in_order() -> None:
    client = Rig().client()
    client.session.receive(b'  queryMotors\nqueryDockStatus\r\n\tECHO\t\n')
    assert client.lines() == [
        'Motors enabled', 'DockingState: Undocked ForcedState: Unforced ChargeState: Not',
        'Echo is off.']


@pytest.mark.parametrize('tail', [b'', b'\n'])
def test_a_command_over_5000_characters_drops_the_client(tail: bytes) -> None:
    client = Rig().client()
    client.session.receive(b'say ' + b'x' * 4997 + tail)
    assert client.lines() == ['String too long'] and client.session.closed


def test_a_command_of_5000_characters_is_taken() -> None:
    client = Rig().client()
    client.session.receive(b'say ' + b'x' * 4996 + b'\n')
    assert client.lines() == ['Saying ' + 'x' * 4996]
