"""Session logs: reproducible, readable, and usable for a replay."""
from __future__ import annotations

import io
from typing import Any, Dict, List

import pytest
import yaml
from sim_builders import ROOM, ROOT, Rig

from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.interface.recording import (
    LogError,
    ReplayServer,
    ReplaySession,
    SessionRecording,
    Transfer,
    escape,
    read_log,
    unescape,
)
from omron_map import MapDocument

VECTORS = yaml.safe_load((ROOT / 'test' / 'vectors' / 'session_log.yaml').read_text())

LOG = """0.000 S> Enter password:
0.100 C> ********
0.100 S> Welcome to the server.
0.100 S> Commands:
0.100 S> End of commands
1.000 C> goto 12
1.050 S> Going to 12
9.000 S> Arrived at 12
10.000 C> stop
10.000 S> Stopping
10.500 S> Stopped
"""


def run_and_log(seed: int) -> str:
    rig = Rig(seed=seed)
    file = io.StringIO()
    rig.server.log = SessionRecording(rig.clock, file)
    client = rig.client()
    link = rig.server.connect_outgoing()
    for time, command in [(1.0, 'goto "East side"'), (4.0, 'status'), (6.5, 'goto 12'),
                          (7.0, 'rangeDeviceGetCurrent Laser_1'), (40.0, 'dock')]:
        rig.clock.advance(time)
        client.send(command)
    rig.clock.advance(100.0)
    rig.server.execute(link, 'oneLineStatus')
    return file.getvalue()


def test_two_runs_with_one_seed_give_the_same_log() -> None:
    first = run_and_log(7)
    assert first == run_and_log(7)
    assert first != run_and_log(8), 'another seed must change the log'
    assert 'Arrived at 12' in first and 'DockingState: Docked' in first


def test_a_log_hides_the_password_and_numbers_the_connections() -> None:
    lines = run_and_log(1).splitlines()
    assert lines[0] == '0.000 S> Enter password:' and lines[1] == '0.000 C> ********'
    assert not any('adept' in line for line in lines)
    assert '1.000 C> goto "East side"' in lines and '1.000 S0> Going to East side' in lines
    assert [str(transfer) for transfer in read_log(lines)] == lines


@pytest.mark.parametrize('line', ['hello', '1.0 X> y', 'C> goto', '-1 C> x'])
def test_a_line_that_is_no_transfer_is_named(line: str) -> None:
    with pytest.raises(LogError, match='line 2 is no transfer'):
        read_log(['0.0 C> ok', line])


def lines_of(session: ReplaySession) -> List[str]:
    text = session.output.decode()
    session.output.clear()
    return text.split('\r\n')[:-1]


def test_a_recorded_session_is_served_again_with_its_timing() -> None:
    clock = SimClock()
    session = ReplayServer(clock, read_log(LOG.splitlines())).connect()
    assert lines_of(session) == ['Enter password:']
    clock.advance(5.0)
    assert lines_of(session) == [], 'the client has not sent anything yet'
    session.receive(b'any password\r\n')
    assert lines_of(session) == ['Welcome to the server.', 'Commands:', 'End of commands']
    session.receive(b'GOTO 12\n')
    clock.advance(5.06)
    assert lines_of(session) == ['Going to 12']
    clock.advance(12.9)
    assert lines_of(session) == []
    clock.advance(13.0)
    assert lines_of(session) == ['Arrived at 12']


def test_a_line_sent_early_waits_for_what_the_robot_still_has_to_say() -> None:
    clock = SimClock()
    session = ReplayServer(clock, read_log(LOG.splitlines())).connect()
    session.receive(b'x\ngoto 12\nstop\n')
    clock.advance(20.0)
    assert lines_of(session)[-4:] == ['Going to 12', 'Arrived at 12', 'Stopping', 'Stopped']


def test_the_client_may_skip_commands_but_not_invent_them() -> None:
    session = ReplayServer(SimClock(), read_log(LOG.splitlines())).connect()
    session.receive(b'x\nechooo off\nstop\n')
    assert lines_of(session)[-2:] == ['Unknown command echooo', 'Stopping']


OVERLAPPING = """0.000 S> Enter password:
0.100 C> ********
1.000 C> odometer
1.001 C> oneLineStatus
1.010 S> Odometer: 0 mm 0 deg 0 sec
1.020 S> Status: Stopped
"""


def test_an_answer_comes_without_a_command_that_the_log_has_before_it() -> None:
    clock = SimClock()
    session = ReplayServer(clock, read_log(OVERLAPPING.splitlines())).connect()
    session.receive(b'x\nodometer\n')
    clock.advance(0.4)
    assert lines_of(session) == ['Enter password:'], 'the second command may still come'
    clock.advance(1.0)
    assert lines_of(session) == ['Odometer: 0 mm 0 deg 0 sec', 'Status: Stopped']


def test_commands_that_overlap_are_answered_in_the_order_of_the_log() -> None:
    clock = SimClock()
    session = ReplayServer(clock, read_log(OVERLAPPING.splitlines())).connect()
    session.receive(b'x\nodometer\n')
    clock.advance(0.2)
    session.receive(b'oneLineStatus\n')
    clock.advance(0.3)
    assert lines_of(session)[1:] == ['Odometer: 0 mm 0 deg 0 sec', 'Status: Stopped']


def test_a_telnet_client_is_understood_by_a_replay() -> None:
    session = ReplayServer(SimClock(), read_log(LOG.splitlines())).connect()
    session.receive(b'\xff\xfb\x1f\xff\xfd\x03x\r\0 stop \r\0\n')
    assert lines_of(session)[-1] == 'Stopping'


def test_a_simulated_session_can_be_replayed() -> None:
    transfers = read_log(run_and_log(2).splitlines())
    clock = SimClock()
    session = ReplayServer(clock, transfers).connect()
    for transfer in transfers:
        if transfer.connection == 1 and transfer.direction == 'C':
            session.receive(transfer.text.encode() + b'\n')
    clock.advance(200.0)
    assert lines_of(session) == [t.text for t in transfers
                                 if t.connection == 1 and t.direction == 'S']


def test_a_name_that_is_not_ascii_comes_back_out_of_a_log_byte_for_byte() -> None:
    rig = Rig(MapDocument.from_bytes(ROOM.replace('"West"', '"K\xfcche \\ 2"').encode('latin-1')))
    file = io.StringIO()
    rig.server.log = SessionRecording(rig.clock, file)
    session = rig.client().session
    session.receive(b'getGoals\n')
    answer = bytes(session.output)
    assert answer.startswith(b'Goal: K\xfcche \\ 2\r\n') and file.getvalue().isascii()
    replayed = ReplayServer(SimClock(), read_log(file.getvalue().splitlines())).connect()
    replayed.receive(b'adept\ngetGoals\n')
    assert replayed.output.endswith(answer)


@pytest.mark.parametrize('row', VECTORS, ids=lambda row: row['line'])
def test_the_log_is_read_and_written_as_documented(row: Dict[str, Any]) -> None:
    data = bytes(row['bytes'])
    transfer = Transfer(row['time'], row['side'], row['connection'], escape(data))
    assert str(transfer) == row['line']
    assert read_log([row['line']]) == [transfer] and unescape(transfer.text) == data


def test_a_transfer_reads_as_it_is_written() -> None:
    assert str(Transfer(1.5, 'C', 2, 'stop')) == '1.500 C2> stop'
