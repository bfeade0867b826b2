"""If a robot misbehaves, the client never hangs, and reports what happened."""
from __future__ import annotations

import inspect
import socket
import threading
from contextlib import contextmanager
from typing import Callable, Iterator

import pytest
from arcl_builders import (
    LOGIN,
    PASSWORD,
    STATUS,
    Noted,
    ScriptedRobot,
    free_port,
    lines,
    wait_for,
)
from drive_bench import PERSON, ROUTE

from omron_arcl import (
    Backoff,
    Client,
    InvalidCommand,
    Link,
    LinkPhase,
    NotConnected,
    Outcome,
    SessionLog,
)
from omron_arcl.commands import DriveCourse
from omron_arcl.errors import StopOwed
from omron_arcl.judgements import SETTLE
from omron_arcl.records import MotionCause
from omron_arcl.transport import TICK


def quick() -> Backoff:
    return Backoff(first=0.02, cap=0.05, wrong_password=0.1)


@pytest.fixture
def robot():
    with ScriptedRobot() as robot:
        yield robot


@pytest.fixture
def links() -> Noted:
    return Noted()


@contextmanager
def connected_client(robot: ScriptedRobot, **options) -> Iterator[Client]:
    with Client('127.0.0.1', robot.port, PASSWORD, backoff=quick(), **options) as client:
        assert client.wait_connected(5.0).connected, client.link
        yield client


@contextmanager
def repeated(send: Callable[[], None]) -> Iterator[None]:
    """Calls `send` again and again until the connection has ended."""
    done = threading.Event()

    def repeat() -> None:
        while not done.wait(0.05):
            try:
                send()
            except OSError:
                return
    thread = threading.Thread(target=repeat)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join(5.0)


def test_it_logs_in_and_carries_a_command(robot):
    robot.answers[b'odometer'] = (b'Odometer: 1 mm 2 deg 3 sec',)
    with connected_client(robot) as client:
        result = client.execute('odometer').wait(20.0)
        assert result.outcome is Outcome.SUCCEEDED
        assert result.lines == ('Odometer: 1 mm 2 deg 3 sec',)
        assert client.help.full_name('goto') == 'goto'
        robot.wait_heard(b'echo off')


def test_lines_are_handed_on_as_they_come(robot):
    noted = Noted()
    with connected_client(robot, on_line=noted):
        robot.say(b'EStop pressed', b'caf\xe9')
        noted.wait(lambda line: line.raw == b'caf\xe9', 'the last line')
        assert b'EStop pressed' in [line.raw for line in noted.all]


def test_the_link_tells_its_phases(robot, links):
    with connected_client(robot, on_link=links):
        links.wait(lambda link: link.connected, 'connected')
    assert [link.phase for link in links.all] == [
        LinkPhase.CONNECTING, LinkPhase.LOGGING_IN, LinkPhase.CONNECTED, LinkPhase.DISCONNECTED]
    assert links.all[-1] == Link(LinkPhase.DISCONNECTED, f'127.0.0.1:{robot.port}', 'closed by us')


def test_a_refused_connection_is_tried_again_until_the_robot_is_there(links):
    port = free_port()
    with Client('127.0.0.1', port, PASSWORD, backoff=quick(), on_link=links) as client:
        links.wait(lambda link: 'refused' in link.reason, 'refused connection')
        with socket.create_server(('127.0.0.1', port)) as server:
            connection, _ = server.accept()
            with connection:
                connection.sendall(lines(*LOGIN))
                assert client.wait_connected(5.0).connected


def test_a_stop_without_a_link_is_told_to_be_owed():
    """Once, the giver read "Not sent", but the stop was sent later."""
    client = Client('127.0.0.1', free_port(), PASSWORD)
    with pytest.raises(StopOwed, match='Not sent yet.*sent as soon as'):
        client.execute('stop')
    with pytest.raises(NotConnected, match='^Not sent, ') as refused:
        client.execute('goto 12')
    assert not isinstance(refused.value, StopOwed)
    client.close()


def test_a_wrong_password_is_told_apart_and_tried_again_later(links):
    with ScriptedRobot(password=b'other') as robot, \
            Client('127.0.0.1', robot.port, PASSWORD, backoff=quick(), on_link=links):
        link = links.wait(lambda link: link.phase is LinkPhase.WRONG_PASSWORD, 'the wrong password')
        assert 'password' in link.reason
        wait_for(lambda: len(robot.connections) >= 2, 'another try')
    assert all(b'adept' not in repr(link).encode() for link in links.all)


def test_who_waits_for_the_login_hears_of_a_wrong_password_at_once():
    patient = Backoff(wrong_password=1000.0)
    with ScriptedRobot(password=b'other') as robot, \
            Client('127.0.0.1', robot.port, PASSWORD, backoff=patient) as client:
        assert client.wait_connected(1000.0).phase is LinkPhase.WRONG_PASSWORD


@pytest.mark.parametrize('reset', [False, True])
def test_a_lost_link_ends_commands_as_lost_and_sends_no_motion_again(robot, links, reset):
    with connected_client(robot, on_link=links) as client:
        goto = client.execute('goto 12')
        robot.wait_heard(b'goto 12')
        robot.drop(reset)
        assert goto.wait(20.0).outcome is Outcome.LOST
        wait_for(lambda: len(robot.connections) == 2 and client.link.connected, 'reconnection')
        robot.answers[b'odometer'] = (b'Odometer: 1 mm 2 deg 3 sec',)
        assert client.execute('odometer').wait(20.0).outcome is Outcome.SUCCEEDED
        assert robot.heard.count(b'goto 12') == 1


def test_a_silent_robot_counts_as_dead(robot, links):
    with connected_client(robot, on_link=links, heartbeat=0.1, timeout=0.4) as client:
        goto = client.execute('goto 12')
        robot.mute = True
        link = links.wait(lambda link: 'nothing was received' in link.reason, 'silence')
        assert link.phase is LinkPhase.DISCONNECTED
        assert goto.wait(20.0).outcome is Outcome.LOST


def test_by_default_a_dead_link_is_noticed_within_five_seconds():
    timeout = inspect.signature(Client).parameters['timeout'].default
    assert timeout + TICK < 5.0


def test_bytes_without_a_line_are_no_sign_of_life(robot, links):
    with connected_client(robot, on_link=links, heartbeat=0.1, timeout=0.5):
        robot.mute = True
        with repeated(lambda: robot.send(robot.connections[0], b'x')):
            links.wait(lambda link: 'nothing was received' in link.reason, 'silence')


def test_a_robot_without_one_line_statuses_is_asked_for_its_status(robot):
    robot.answers.update({b'status': (b'Status: Stopped', b'Temperature: 36')})
    robot.unknown.add(b'oneLineStatus')
    with connected_client(robot, heartbeat=0.05, timeout=1.0) as client:
        robot.wait_heard(b'status')
        wait_for(lambda: robot.heard.count(b'status') >= 5, 'heartbeats')
        assert robot.heard.count(b'oneLineStatus') == 1
        assert client.link.connected


def test_a_name_that_is_not_ascii_is_sent_as_the_robot_listed_it(robot):
    robot.answers[b'getGoals'] = (b'Goal: K\xfcche', 'Goal: Caf\xe9'.encode(), b'Goal: "a b"',
                                  b'End of goals')
    with connected_client(robot) as client:
        with pytest.raises(InvalidCommand, match='has listed'):
            client.execute('goto K\xfcche')
        result = client.execute('getGoals').wait(20.0)
        assert result.lines == ('Goal: K\xfcche', 'Goal: Caf\xe9', 'Goal: "a b"', 'End of goals')
        assert client.names == {'K\xfcche': b'K\xfcche', 'Caf\xe9': 'Caf\xe9'.encode()}
        client.execute('goto k\xfcche')
        client.execute('goto Caf\xe9')
        robot.wait_heard(b'goto K\xfcche')
        robot.wait_heard('goto Caf\xe9'.encode())
        robot.say(b'Arrived at K\xfcche', b'Map changed')
        wait_for(lambda: not client.names, 'the names of another map')


def test_what_a_command_keeps_is_bounded_and_what_is_left_out_is_counted(robot):
    robot.answers[b'getGoals'] = (*[b'Goal: ' + b'x' * 100_000] * 100, b'End of goals')
    with connected_client(robot) as client:
        result = client.execute('getGoals').wait(20.0)
        assert result.outcome is Outcome.SUCCEEDED
        assert sum(map(len, result.lines)) <= 4_000_000
        assert len(result.lines) + result.left_out == 101


def test_a_login_without_prompt_welcome_or_help_list_succeeds(monkeypatch):
    for silence in ('PROMPT_TIMEOUT', 'WELCOME_TIMEOUT', 'HELP_TIMEOUT'):
        monkeypatch.setattr(f'omron_arcl.session.{silence}', 0.3)
    with ScriptedRobot(login=False) as robot, connected_client(robot, heartbeat=0.2) as client:
        assert not client.help.complete
        assert robot.heard[:2] == [PASSWORD, b'oneLineStatus']


def test_a_login_that_fails_says_what_was_received(links, monkeypatch):
    monkeypatch.setattr('omron_arcl.arcl_link.LOGIN_SILENCE', 1.0)
    with ScriptedRobot(login=False) as robot:
        robot.mute = True
        with Client('127.0.0.1', robot.port, PASSWORD, backoff=quick(), on_link=links,
                    heartbeat=0.1, timeout=0.3):
            wait_for(lambda: robot.connections, 'a connection')
            robot.say(b'220 some FTP server')
            link = links.wait(lambda link: 'nothing was received' in link.reason, 'the reason',
                              timeout=10.0)
            assert 'after "220 some FTP server"' in link.reason


def test_a_robot_with_nothing_to_say_stays_connected_by_heartbeats(robot, links):
    with connected_client(robot, on_link=links, heartbeat=0.05, timeout=0.3):
        wait_for(lambda: robot.heard.count(b'oneLineStatus') >= 10, 'ten heartbeats')
        assert links.all[-1].connected


def test_a_silent_server_is_given_up_during_the_login(links, monkeypatch):
    monkeypatch.setattr('omron_arcl.arcl_link.LOGIN_SILENCE', 1.0)
    with ScriptedRobot(login=False) as robot:
        robot.mute = True
        with Client('127.0.0.1', robot.port, PASSWORD, backoff=quick(), on_link=links,
                    heartbeat=0.1, timeout=0.3):
            links.wait(lambda link: 'nothing was received' in link.reason, 'silence', timeout=10.0)


def test_a_login_that_never_ends_is_given_up_although_lines_come(links, monkeypatch):
    monkeypatch.setattr('omron_arcl.arcl_link.LOGIN_TIMEOUT', 0.5)
    monkeypatch.setattr('omron_arcl.session.PROMPT_TIMEOUT', 60.0)
    with ScriptedRobot(login=False) as robot:
        robot.mute = True
        with Client('127.0.0.1', robot.port, PASSWORD, backoff=quick(), on_link=links):
            wait_for(lambda: robot.connections, 'a connection')
            with repeated(lambda: robot.send(robot.connections[0], lines(b'220 FTP'))):
                link = links.wait(lambda link: 'the login took' in link.reason, 'the reason')
            assert 'the server said "220 FTP' in link.reason
            assert not link.connected


def test_commands_are_refused_while_nobody_is_connected():
    with Client('127.0.0.1', free_port(), PASSWORD, backoff=quick()) as client, \
            pytest.raises(NotConnected):
        client.execute('stop')


def test_what_is_no_command_is_refused(robot):
    with connected_client(robot) as client:
        with pytest.raises(InvalidCommand):
            client.execute('goto 1\nstop')
        assert b'goto 1' not in robot.heard


def test_a_stop_passes_everything_that_waits(robot):
    with connected_client(robot) as client:
        first, *waiting = [client.execute('getGoals') for _ in range(50)]
        client.execute('stop')
        robot.wait_heard(b'stop')
        assert robot.heard.count(b'getGoals') == 1
        assert all(not execution.sent for execution in waiting)
        assert first.sent


def test_cancelling_a_drive_sends_stop(robot):
    robot.answers.update({b'goto 12': (b'Going to 12',),
                          b'stop': (b'Interrupted: Going to 12', b'Stopping', b'Stopped')})
    with connected_client(robot) as client:
        goto = client.execute('goto 12')
        client.cancel(goto)
        assert goto.wait(20.0).outcome is Outcome.CANCELLED


def test_cancelling_everything_stops_the_drive_of_another_giver_and_tells_it(robot):
    motions = Noted()
    with connected_client(robot, on_motion=motions) as client:
        goto = client.execute('goto 12', giver=ROUTE)
        robot.wait_heard(b'goto 12')
        robot.say(b'Going to 12')
        motions.wait(lambda motion: motion.memory.giver == ROUTE, 'the drive')
        client.cancel_all(PERSON)
        robot.wait_heard(b'stop')
        robot.say(b'Stopping', b'Stopped')
        assert goto.wait(20.0).outcome is not Outcome.SUCCEEDED
        told = motions.wait(lambda motion: motion.memory.cause is MotionCause.CANCEL
                            and not motion.memory.stop_owed, 'the end of the cancellation')
        assert told.memory.giver != ROUTE
        assert client.motion.memory.epoch == told.memory.epoch
    assert robot.heard.count(b'goto 12') == 1


def test_a_drive_that_somebody_stops_without_a_word_of_it_ends(robot, monkeypatch):
    monkeypatch.setitem(SETTLE, DriveCourse.TO_A_PLACE, 1.0)
    robot.answers[b'goto 12'] = (b'Going to 12',)  # but its status always says Stopped
    with connected_client(robot) as client:
        goto = client.execute('goto 12')
        robot.wait_heard(b'goto 12')
        robot.say(b'Stopping', b'Stopped')
        result = goto.wait(20.0)
        assert result.outcome is Outcome.INTERRUPTED
        assert b'stop' not in robot.heard


def test_a_callback_may_give_the_next_command(robot):
    robot.answers[b'odometer'] = (b'Odometer: 1 mm 2 deg 3 sec',)
    ends = Noted()
    with connected_client(robot) as client:
        client.execute('odometer', on_end=lambda result: client.execute('odometer', on_end=ends))
        ends.wait(lambda result: result.outcome is Outcome.SUCCEEDED, 'second answer')


def test_a_callback_that_fails_does_not_end_the_connection(robot, caplog):
    def fail(line):
        raise RuntimeError('a mistake of the caller')
    robot.answers[b'odometer'] = (b'Odometer: 1 mm 2 deg 3 sec',)
    with connected_client(robot, on_line=fail) as client:
        assert client.execute('odometer').wait(20.0).outcome is Outcome.SUCCEEDED
    assert 'a mistake of the caller' in caplog.text


def test_a_garbled_line_costs_no_good_one(robot):
    noted = Noted()
    with connected_client(robot, on_line=noted):
        robot.say(b'\x00\xff\xfb\xfe' * 100, b'Stopped', b'Location: x', b'Stopping')
        noted.wait(lambda line: line.raw == b'Stopping', 'the last line')
        assert b'Stopped' in [line.raw for line in noted.all]


def test_a_line_beyond_all_measure_ends_the_link_with_a_reason(robot, links):
    with connected_client(robot, on_link=links):
        flood = threading.Thread(target=_flood, args=(robot, b'x' * 65536))
        flood.start()
        links.wait(lambda link: 'more than' in link.reason, 'the reason')
        flood.join(5.0)


def test_a_stop_gets_through_a_flood_of_twenty_megabytes(robot):
    robot.answers[b'stop'] = (b'Stopping', b'Stopped')
    noted = [0]

    def count(line) -> None:
        noted[0] += 1
    said = (*STATUS, b'RangeDeviceGetCurrent: Laser_1' + b' -1234 5678' * 455)
    piece, pieces = lines(*said) * 40, 100
    with connected_client(robot, on_line=count) as client:
        wait_for(lambda: noted[0], 'the answer to the login')
        flood = threading.Thread(target=_flood, args=(robot, piece, pieces))
        flood.start()
        stop = client.execute('stop')
        robot.wait_heard(b'stop', 20.0)
        flood.join(60.0)
        assert stop.wait(20.0).outcome is Outcome.SUCCEEDED
        wait_for(lambda: noted[0] >= 40 * pieces * len(said), 'every line of the flood', 60.0)
        assert len(piece) * pieces > 20_000_000


def test_a_line_that_drips_in_byte_by_byte_is_one_line(robot):
    noted = Noted()
    robot.mute = True  # the robot sends no other line, not even an answer to a heartbeat
    with connected_client(robot, on_line=noted):
        for byte in b'Arrived at 12\r\n':
            robot.connections[-1].sendall(bytes([byte]))
        noted.wait(lambda line: line.raw == b'Arrived at 12', 'the line')


def test_closing_takes_less_than_a_second_wherever_the_client_is(robot):
    with ScriptedRobot(login=False) as silent:
        slow = Backoff(first=60.0, cap=60.0)
        clients = [Client('127.0.0.1', port, PASSWORD, backoff=slow).start()
                   for port in (robot.port, silent.port, free_port())]
        clients[0].wait_connected(5.0)
        wait_for(lambda: silent.connections, 'a connection')
        wait_for(lambda: 'refused' in clients[2].link.reason, 'a refused connection')
        for client in clients:
            client.close()  # waits at most a second
            assert not client._thread.is_alive()


def test_the_session_log_holds_both_sides_by_connection_without_the_password(robot, tmp_path):
    path = tmp_path / 'session.log'
    path.write_text('an older one')
    robot.answers[b'odometer'] = (b'Odometer: 1 mm 2 deg 3 sec',)
    log = SessionLog(str(path))
    with connected_client(robot, log=log) as client:
        client.execute('odometer').wait(20.0)
        robot.say(b'caf\xe9\x01')
        robot.drop()
        wait_for(lambda: len(robot.connections) == 2 and client.link.connected, 'reconnection')
        client.execute('odometer').wait(20.0)
    log.close()
    written = path.read_text(encoding='ascii')
    said = [line.split(' ', 1)[1] for line in written.splitlines()]
    assert said[:3] == ['S> Enter password:', 'C> ********', 'S> Welcome to the server.']
    for line in ('C> odometer', 'S> Odometer: 1 mm 2 deg 3 sec', r'S> caf\xe9\x01', 'C2> odometer'):
        assert line in said
    assert 'adept' not in written
    assert (tmp_path / 'session.log.old').read_text() == 'an older one'


def _flood(robot: ScriptedRobot, data: bytes, times: int = 400) -> None:
    try:
        for _ in range(times):
            robot.send(robot.connections[0], data)
    except OSError:
        return  # the client has closed the connection
