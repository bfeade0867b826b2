"""Client and listener against the simulated LD-90, with injected faults."""
from __future__ import annotations

import math
import threading
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

import pytest
from arcl_builders import PASSWORD, Noted, wait_for

from omron_arcl import (
    COMMANDS,
    Backoff,
    Client,
    LinkPhase,
    Listener,
    Outcome,
    SessionLog,
    parse_line,
)
from omron_arcl.replies import Location, RangeReading, UnknownLine
from omron_ld90_sim import Simulator
from omron_ld90_sim.interface.recording import read_log
from omron_ld90_sim.interface.simulator import Replay

LAB = Path(__file__).parents[3] / 'maps' / 'lab.map'
PATIENCE = 20.0  # s


@pytest.fixture(scope='module')
def shared_robot():
    with Simulator(LAB, speed=10.0) as robot:
        yield robot


@pytest.fixture
def robot():
    with Simulator(LAB, speed=10.0) as robot:
        yield robot


@contextmanager
def client_of(robot, **options) -> Iterator[Client]:
    backoff = Backoff(first=0.05, cap=0.1, wrong_password=0.2)
    with Client('127.0.0.1', robot.port, PASSWORD, backoff=backoff, **options) as client:
        assert client.wait_connected(PATIENCE).connected, client.link
        yield client


QUERIES = ('status', 'oneLineStatus', 'getGoals', 'getRoutes', 'getMacros', 'odometer',
           'queryDockStatus', 'queryMotors', 'getDateTime', 'rangeDeviceGetList',
           'rangeDeviceGetCurrent Laser_1', 'rangeDeviceGetCumulative Laser_1',
           'mapObjectTypeList', 'mapObjectTypeInfo Goal', 'mapObjectList Goal', 'mapObjectInfo 8',
           'getConfigSectionList', 'getConfigSectionValues Files', 'getConfigSectionInfo Files',
           'applicationFaultQuery', 'faultsGet', 'inputList', 'outputList', 'analogInputList',
           'help', 'echo', 'waitTaskState', 'getInfoList', 'getInfo Flags',
           'distanceBetween 8 20', 'getDataStoreGroupList', 'getDataStoreTripGroupList',
           'getDataStoreFieldList', 'getDataStoreGroupInfo TripStateInformation',
           'getDataStoreGroupValues TripStateInformation', 'extIODump', 'extIODumpLocal',
           'payloadQueryLocal', 'payloadSlotCountLocal')
CHANGES = ('odometerReset', 'tripReset', 'createInfo place 10 here', 'updateInfo place there',
           'applicationFaultSet f "a fault" "no more" 0 0', 'applicationFaultClear f',
           'extIOAdd bank 8 8', 'extIOInputUpdate bank 0x3', 'extIOInputUpdateBit bank 2 1',
           'extIOInputUpdateByte bank 1 255', 'extIOOutputUpdate bank 7',
           'extIOOutputUpdateBit bank 1 0', 'extIOOutputUpdateByte bank 1 0x10',
           'payloadSet 1 Books', 'payloadRemove 1', 'say "hello"', 'log message Terse',
           'popupSimple "title" "text" "button" 5', 'doTaskInstant sayInstant "hello"')


@pytest.mark.parametrize('query', QUERIES)
def test_every_query_ends_and_every_line_of_it_is_known(shared_robot, query):
    with client_of(shared_robot) as client:
        result = client.execute(query).wait(PATIENCE)
        assert result.outcome is Outcome.SUCCEEDED, result
        assert not [line for line in result.lines if isinstance(parse_line(line), UnknownLine)]


def test_every_change_is_confirmed_in_known_words(robot):
    with client_of(robot) as client:
        for change in CHANGES:
            result = client.execute(change).wait(PATIENCE)
            assert result.outcome is Outcome.SUCCEEDED, (change, result)
            assert not [line for line in result.lines if isinstance(parse_line(line), UnknownLine)]


def test_every_command_of_the_robot_is_in_the_table(shared_robot):
    with client_of(shared_robot) as client:
        assert len(client.help) > 50
        assert not {name for name in client.help.descriptions if name.lower() not in COMMANDS}


def test_a_drive_arrives_where_the_map_says(robot):
    with client_of(robot) as client:
        assert client.execute('goto 8').wait(PATIENCE).outcome is Outcome.SUCCEEDED
        coordinates = parse_line(client.execute('mapObjectInfo 8').wait(PATIENCE).lines[-2])
        x, y, _ = robot.pose
        assert abs(x - coordinates.x) < 150.0
        assert abs(y - coordinates.y) < 150.0


def test_dock_and_undock_end_by_the_docking_state(robot):
    with client_of(robot) as client:
        for command in ('undock', 'dock', 'undock'):
            assert client.execute(command).wait(PATIENCE).outcome is Outcome.SUCCEEDED


@pytest.mark.parametrize('words', ['name', 'coordinates'])
def test_a_drive_that_another_client_stops_as_the_robot_leaves_its_dock_ends_at_once(robot, words):
    robot.inject(f'dialect interrupted {words}')
    said = Noted()
    with client_of(robot, heartbeat=0.1, on_line=lambda line: said(line.text)) as client, \
            client_of(robot) as other:
        said.wait(lambda line: line.startswith('Status: DockingState: Docked'), 'docked', PATIENCE)
        drive = client.execute('goto 20')
        said.wait(lambda line: line.startswith('DockingState: Undocking'), 'undocking', PATIENCE)
        assert other.execute('stop').wait(PATIENCE).outcome is Outcome.SUCCEEDED
        result = drive.wait(5.0)
        assert result is not None and result.outcome is Outcome.INTERRUPTED, result


def test_a_drive_that_fails_ends_with_the_robots_words(robot):
    robot.inject('fail 8')
    with client_of(robot) as client:
        result = client.execute('goto 8').wait(PATIENCE)
        assert result.outcome is Outcome.FAILED
        assert 'Failed going to goal' in result.words


def test_stops_and_drives_behind_a_failed_drive_are_carried_out_every_time(robot):
    """The drive fails while the robot still moves. So stops and drives arrive while it brakes."""
    robot.inject('fail 8')
    begun = Noted()
    with client_of(robot, heartbeat=0.1, on_line=lambda line: begun(line.text)) as client:
        client.execute('goto 20')
        for _ in range(5):
            before = len(begun.all)
            begun.wait(lambda line: line.startswith('Status: '), 'a while of driving', PATIENCE,
                       before)
            assert client.execute('goto 8').wait(PATIENCE).outcome is Outcome.FAILED
            before = len(begun.all)
            stops = [client.execute('stop'), client.execute('stop')]
            drive = client.execute('goto 20')
            begun.wait(lambda line: line == 'Going to 20', 'the next drive', PATIENCE, before)
            for stop in stops:
                assert stop.wait(PATIENCE).outcome in (Outcome.SUCCEEDED, Outcome.INTERRUPTED)
        assert drive.wait(PATIENCE).outcome is Outcome.SUCCEEDED


def test_an_emergency_stop_ends_the_drive(robot):
    with client_of(robot) as client:
        begun = Noted()
        goto = client.execute('goto 8', on_line=begun)
        begun.wait(lambda line: line == 'Going to 8', 'the drive', PATIENCE)
        robot.inject('estop press')
        result = goto.wait(PATIENCE)
        assert result.outcome is Outcome.EMERGENCY_STOPPED
        assert client.execute('enableMotors').wait(PATIENCE).outcome is Outcome.EMERGENCY_STOPPED
        robot.inject('estop release')
        assert client.execute('enableMotors').wait(PATIENCE).outcome is Outcome.SUCCEEDED


def test_another_client_that_drives_interrupts_ours(robot):
    with client_of(robot) as ours, client_of(robot) as theirs:
        begun = Noted()
        goto = ours.execute('goto 8', on_line=begun)
        begun.wait(lambda line: line == 'Going to 8', 'the drive', PATIENCE)
        theirs.execute('goto 20')
        assert goto.wait(PATIENCE).outcome is Outcome.INTERRUPTED


def test_a_stop_that_another_client_overtakes_ends_at_once_with_what_happened(robot):
    with client_of(robot) as client:
        lines = Noted()
        goto = client.execute('goto 8', on_line=lines)
        lines.wait(lambda line: line == 'Going to 8', 'the drive', PATIENCE)
        x, y, _ = robot.pose
        wait_for(lambda: math.hypot(robot.pose[0] - x, robot.pose[1] - y) > 500.0, 'half a metre',
                 PATIENCE)

        def overtake(line: str) -> None:  # while the robot brakes
            if line == 'Stopping':
                robot.inject('other goto 20')

        result = client.execute('stop', on_line=overtake).wait(10.0)
        assert result, 'the stop must still wait for a robot that drives for another client'
        assert result.outcome is Outcome.INTERRUPTED
        assert result.words == 'taken over: Going to 20'
        assert goto.result.words == 'Interrupted: Going to 8'


def test_two_clients_get_their_own_answers(robot):
    with client_of(robot) as first, client_of(robot) as second:
        executions = [client.execute(query) for _ in range(20)
                      for client, query in ((first, 'odometer'), (second, 'getGoals'))]
        results = [execution.wait(PATIENCE) for execution in executions]
        assert {len(result.lines) for result in results[::2]} == {1}
        assert all(result.lines[-1] == 'End of goals' for result in results[1::2])


def test_a_reboot_in_the_middle_of_a_drive_is_survived_and_the_drive_not_repeated(robot):
    links, lines = Noted(), Noted()
    with client_of(robot, on_link=links, on_line=lines) as client:
        goto = client.execute('goto 8')
        lines.wait(lambda line: line.raw == b'Going to 8', 'the drive', PATIENCE)
        robot.inject('reboot 3')
        assert goto.wait(PATIENCE).outcome is Outcome.LOST
        links.wait(lambda link: 'refused' in link.reason, 'the closed port', PATIENCE)
        assert client.wait_connected(PATIENCE).connected
        before = robot.pose
        assert client.execute('odometer').wait(PATIENCE).outcome is Outcome.SUCCEEDED
        assert robot.pose == before, 'the robot drives again'


@pytest.mark.parametrize(('fault', 'mend', 'reasons'), [
    # TCP resets a connection that is closed while received bytes (here a heartbeat) are unread
    ('drop', '', ('closed the connection', 'reset')),
    ('reset', '', ('reset',)),
    ('silence 60', 'silence 0', ('nothing was received',)),
])
def test_a_broken_link_is_noticed_named_and_made_again(robot, fault, mend, reasons):
    links = Noted()
    with client_of(robot, on_link=links, heartbeat=0.2, timeout=1.0) as client:
        robot.inject(fault)
        links.wait(lambda link: any(reason in link.reason for reason in reasons),
                   f'one of the reasons {reasons}', PATIENCE)
        if mend:
            robot.inject(mend)
        assert client.wait_connected(PATIENCE).connected


def test_a_line_cut_in_two_is_one_line(robot):
    with client_of(robot) as client:
        robot.inject('halfline 2')
        result = client.execute('odometer').wait(PATIENCE)
        assert result.outcome is Outcome.SUCCEEDED
        assert result.lines[0].startswith('Odometer: ')


def test_a_prompt_in_other_words_is_answered(robot):
    robot.inject('prompt Username:')
    with Client('127.0.0.1', robot.port, PASSWORD) as client:
        assert client.wait_connected(PATIENCE).connected


def test_a_wrong_password_is_told_apart(shared_robot):
    links = Noted()
    with Client('127.0.0.1', shared_robot.port, b'wrong', on_link=links):
        links.wait(lambda link: link.phase is LinkPhase.WRONG_PASSWORD, 'wrong password', PATIENCE)


def test_the_outgoing_connection_brings_statuses_and_scans():
    lines = Noted()
    with Listener('127.0.0.1', 0, '127.0.0.1', on_line=lines) as listener, \
            Simulator(LAB, speed=10.0, outgoing=('127.0.0.1', listener.port)) as robot:
        lines.wait(lambda line: isinstance(line.reply, Location), 'a location', PATIENCE)
        scan = lines.wait(lambda line: isinstance(line.reply, RangeReading), 'a scan', PATIENCE)
        assert scan.reply.device == 'Laser_1'
        assert len(scan.reply.points) > 50
        robot.inject('outgoing off')
        wait_for(lambda: not listener.link.connected, 'the cut', PATIENCE)
        robot.inject('outgoing on')
        wait_for(lambda: listener.link.connected, 'the new connection', PATIENCE)


def test_the_simulator_replays_a_session_log_of_ours(robot, tmp_path):
    path = tmp_path / 'session.log'
    log = SessionLog(str(path))
    with client_of(robot, log=log) as client:
        recorded = client.execute('getGoals').wait(PATIENCE)
    log.close()
    replay = Replay(read_log(path.read_text().splitlines()), speed=10.0)
    thread = threading.Thread(target=replay.run)
    thread.start()
    try:
        with client_of(replay) as client:
            assert client.execute('getGoals').wait(PATIENCE) == recorded
    finally:
        replay.stop()
        thread.join(5.0)
