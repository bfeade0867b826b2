"""The parts of the node: its file, and the meaning of the fleet manager's messages."""
from __future__ import annotations

import copy
import shutil
import socket
import sqlite3

import pytest
import rospy

from itrci_nav_msgs.msg import FleetRobot, FleetState, MissionCommand, MissionStatus
from itrci_nav_msgs.srv import ExplainMissionResponse
from node_lifecycle import ConfigurationError
from omron_jobs.core.job_book import JobCounters
from omron_jobs.core.job_words import RobotStatus, SegmentKind, SegmentStatus
from omron_jobs.core.jobs import (
    DriveAct,
    JobDrive,
    JobMission,
    JobMissionState,
    JobSegment,
    Place,
    QueuedJob,
    Told,
)
from omron_jobs.core.posted_records import PostedRecord
from omron_jobs.core.robots import RobotNews
from omron_jobs.nodes.fleet_news import (
    WrongStatus,
    drives_of,
    mission_of,
    robots_of,
    stamp_of,
)
from omron_jobs.nodes.job_file import JobFile
from omron_jobs.nodes.job_server import JobServerNode, stamp

JOB = QueuedJob('own', (
    JobSegment(7, SegmentKind.PICKUP, 'x', 1, 10, Told(SegmentStatus.COMPLETED, 'None', 'r'), 9),
    JobSegment(8, SegmentKind.DROPOFF, 'y', 2, 20, Told(SegmentStatus.IN_PROGRESS, 'Driving', 'r'),
               0, Place('z', 3)),
), 1324277658123, 41, True, 'late')
OTHER = QueuedJob('JOB9', (JobSegment(9, SegmentKind.PICKUP, 'x', 1, 10),), 1, 42)
COUNTERS = JobCounters(10, 3, 2)

# -- the file --------------------------------------------------------------------------------------


def test_jobs_come_back(tmp_path):
    path = str(tmp_path / 'new' / 'jobs.sqlite')
    file = JobFile(path, '~jobs_file')
    assert file.read() == ([], JobCounters())
    file.write([JOB, OTHER], (), COUNTERS)
    file.write([], [42], COUNTERS)
    file.close()
    other = str(tmp_path / 'other.sqlite')  # this process has locked the first file
    shutil.copy(path, other)
    assert JobFile(other, '~jobs_file').read() == ([JOB], COUNTERS)


def test_the_last_posted_records_of_each_type_come_back_in_order(tmp_path, monkeypatch):
    monkeypatch.setattr('omron_jobs.nodes.job_file.MOST_POSTED', 3)
    path = str(tmp_path / 'jobs.sqlite')
    with sqlite3.connect(path) as older:  # a file of a version without posted records
        older.executescript("""
            CREATE TABLE job (mission INTEGER PRIMARY KEY, record TEXT NOT NULL);
            CREATE TABLE counters (one INTEGER PRIMARY KEY CHECK (one = 1), record TEXT NOT NULL);
            PRAGMA user_version = 1;""")
    file = JobFile(path, '~jobs_file')
    assert file.read_posted() == []
    cancels = [PostedRecord('JobCancel', number, 7, {'namekey': f'~{number}', 'cancelReason': None})
               for number in range(1, 8)]
    change = PostedRecord('JobSegmentModify', 1, 8, {'namekey': 'own', 'priority': 3})
    for one in (change, *cancels):
        file.write([], (), COUNTERS, one)
    with pytest.raises(OSError):
        file.write([OTHER], (), COUNTERS, change)  # a number can be used only once
    found = file.read_posted()
    assert [one for one in found if one.kind == 'JobCancel'] == cancels[4:]
    assert [one for one in found if one.kind != 'JobCancel'] == [change]
    assert file.read() == ([], COUNTERS)


@pytest.mark.parametrize('content', [b'no database at all' * 100, None])
def test_a_file_that_cannot_be_read_is_no_empty_one(tmp_path, content):
    path = tmp_path / 'jobs.sqlite'
    if content is None:
        with sqlite3.connect(str(path)) as connection:
            connection.execute('PRAGMA user_version = 7')
    else:
        path.write_bytes(content)
    with pytest.raises(ConfigurationError, match='~jobs_file'):
        JobFile(str(path), '~jobs_file').read()


def test_a_record_that_is_none_is_refused(tmp_path):
    file = JobFile(str(tmp_path / 'jobs.sqlite'), '~jobs_file')
    file._database.execute("INSERT INTO job VALUES (1, '{}')")
    with pytest.raises(ConfigurationError, match='other fields'):
        file.read()


def test_a_full_disk_raises_and_stores_nothing(tmp_path, on_small_disk):
    def act(disk):
        file = JobFile(str(disk.folder / 'jobs.sqlite'), '~jobs_file')
        file.write([OTHER], (), COUNTERS)
        many = [QueuedJob(f'{k}' * 100, JOB.segments, 1, k) for k in range(100, 2000)]
        with disk.full(), pytest.raises(OSError):
            file.write(many, (), JobCounters(5000))
        assert file.read() == ([OTHER], COUNTERS)
        file.close()
    on_small_disk(act)


# -- messages --------------------------------------------------------------------------------------


def test_the_states_of_missions_have_the_numbers_of_the_message():
    assert {state.name: state.value for state in JobMissionState} == {
        state.name: getattr(MissionStatus, state.name) for state in JobMissionState}


def test_a_status_is_read():
    status = MissionStatus(request_id=41, state=MissionStatus.ACTIVE, robot='r',
                           destinations_reached=1, priority=-3, destinations=[4, 5])
    assert mission_of(status) == JobMission(JobMissionState.ACTIVE, 'r', 1, -3, (4, 5))
    status.command_code = MissionStatus.COMMAND_NOT_DONE
    for command in (MissionCommand.MODIFY, MissionCommand.CANCEL):
        status.command = command
        assert mission_of(status).is_refusal == (command == MissionCommand.MODIFY)
    status.state = 99
    with pytest.raises(WrongStatus):
        mission_of(status)


@pytest.mark.parametrize('queued', [1, 999, 1000, 1324277658123, 1774277658999])
def test_a_stamp_comes_back_although_the_fleet_manager_rounds_it(queued):
    job = QueuedJob('j', JOB.segments, queued, 41)
    status = MissionStatus()
    status.request_stamp = type(stamp(job)).from_sec(stamp(job).to_sec())
    assert stamp_of(status) == queued


@pytest.mark.parametrize('robot, shown', [
    (FleetRobot(state=FleetRobot.IDLE), RobotNews(RobotStatus.AVAILABLE, 'Available')),
    (FleetRobot(state=FleetRobot.BUSY, destination=3), RobotNews(RobotStatus.AVAILABLE, 'Parking')),
    (FleetRobot(state=FleetRobot.CHARGING), RobotNews(RobotStatus.AVAILABLE, 'DockParked')),
    (FleetRobot(state=FleetRobot.BUSY, has_mission=True, request_id=41),
     RobotNews(RobotStatus.IN_PROGRESS, 'Allocated')),
    (FleetRobot(state=FleetRobot.BUSY, has_mission=True, request_id=5),
     RobotNews(RobotStatus.IN_PROGRESS, 'Driving')),
    (FleetRobot(state=FleetRobot.STOPPED, has_mission=True, request_id=41),
     RobotNews(RobotStatus.UNAVAILABLE, 'EStopPressed'))])
def test_a_robot_is_shown_in_the_words_of_omron(robot, shown):
    robot.name = 'r'
    assert robots_of(FleetState(robots=[robot]), {41: 'Allocated'}.get) == {'r': shown}


def test_a_robot_drives_for_its_mission_unless_it_waits_or_cannot_work():
    driving = FleetRobot(name='r', state=FleetRobot.BUSY, has_mission=True, request_id=41,
                         destination=3, waits_for_code=ExplainMissionResponse.NOTHING)
    assert drives_of(FleetState(robots=[driving])) == {41: JobDrive('r', 3)}
    for left, act in ((2.5, DriveAct.WAITS), (0.0, DriveAct.WORKS)):
        waiting = copy.copy(driving)
        waiting.waits_for_code, waiting.to_destination = ExplainMissionResponse.STEP, left
        assert drives_of(FleetState(robots=[waiting])) == {41: JobDrive('r', 3, act)}
    driving.to_destination = float('nan')
    for field, value in (('waits_for_code', ExplainMissionResponse.STEP), ('has_mission', False),
                         ('state', FleetRobot.STOPPED), ('destination', 0)):
        other = copy.copy(driving)
        setattr(other, field, value)
        assert drives_of(FleetState(robots=[other])) == {}


def test_every_state_of_a_robot_has_its_words():
    states = [value for name, value in vars(FleetRobot).items()
              if name.isupper() and not name.startswith(('OUTAGE', 'LOAD'))
              and isinstance(value, int)]
    assert len(states) == 11
    shown = [robots_of(FleetState(robots=[FleetRobot(name='r', state=state)]), {}.get)['r']
             for state in states]
    assert sum(one.status is RobotStatus.UNAVAILABLE for one in shown) == 8


# -- the ports -------------------------------------------------------------------------------------


def test_a_node_that_lacks_one_of_its_ports_listens_on_none(tmp_path, monkeypatch):
    """If one port listened, its client would connect, and wait for an answer for ever."""
    password = tmp_path / 'password'
    password.write_text('a-password')
    password.chmod(0o600)
    with socket.create_server(('127.0.0.1', 0)) as taken, socket.socket() as free:
        free.bind(('127.0.0.1', 0))
        port = free.getsockname()[1]
        free.close()
        values = {'~password_file': str(password), '~rest_password_file': str(password),
                  '~jobs_file': str(tmp_path / 'jobs.sqlite'), '~port': port,
                  '~rest_port': taken.getsockname()[1]}
        monkeypatch.setattr(rospy, 'get_param', lambda name, default=None: values.get(
            name, default))
        monkeypatch.setattr(rospy, 'resolve_name', lambda name: name.replace('~', '/job_server/'))
        with pytest.raises(ConfigurationError, match='~rest_port'):
            JobServerNode()
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(('127.0.0.1', port))
