"""The state of the motion survives the process, and is published."""
from __future__ import annotations

import json
from dataclasses import replace

import pytest
import rospy

from json_records import to_json
from omron_arcl.execution import Giver
from omron_arcl.records import (
    CommandFate,
    DriveMemory,
    DriveRecord,
    Fate,
    LastCommand,
    MotionCause,
    MotionState,
    RecordKind,
    RobotMotion,
)
from omron_ld90.nodes import controller_motion
from omron_ld90.nodes.controller_motion import MotionFile, message_of
from omron_ld90_msgs import msg

GIVER = Giver('/bridge', 'http://host:1/')
DRIVE = DriveRecord(3, RecordKind.DRIVE, Fate.OVER, GIVER, '12', ('12', '13'),
                    '"goto 12" of /bridge',
                    2 ** 41, CommandFate.FAILED)
LAST = LastCommand('/bridge', 2 ** 41, CommandFate.FAILED, 2 ** 63)
STOP = DriveRecord(4, RecordKind.STOP, Fate.GIVEN, GIVER, words='"stop" of /rviz')
MEMORY = DriveMemory(2 ** 64 - 1, 7, 6, MotionCause.STOP, '"stop" of /rviz', (DRIVE, STOP), (LAST,))


def test_what_was_kept_is_read(tmp_path):
    path = str(tmp_path / 'folder' / 'motion.json')
    MotionFile(path).keep(MEMORY)
    assert MotionFile(path).read() == MEMORY
    assert [file.name for file in (tmp_path / 'folder').iterdir()] == ['motion.json']


def test_a_relative_path_begins_in_ros_home(tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    MotionFile('omron_ld90/r_motion.json').keep(MEMORY)
    assert (tmp_path / 'omron_ld90' / 'r_motion.json').exists()


def test_without_a_file_nothing_is_kept(tmp_path):
    file = MotionFile('')
    file.keep(MEMORY)
    assert file.read() is None
    assert MotionFile(str(tmp_path / 'none.json')).read() is None


@pytest.mark.parametrize('before, after', [('sim_1', 'sim_2'), ('sim_1', ''), ('', 'sim_2')])
def test_what_another_robot_did_says_nothing_about_this_one(tmp_path, before, after):
    """A simulated robot begins anew at each start. With the old memory, it would seem that another
    client had driven it.
    """
    path = str(tmp_path / 'motion.json')
    MotionFile(path, before).keep(MEMORY)
    assert MotionFile(path, before).read() == MEMORY
    assert MotionFile(path, after).read() is None


def test_a_file_of_before_there_were_ids_is_that_of_the_real_robot(tmp_path):
    path = tmp_path / 'motion.json'
    path.write_text(json.dumps(to_json(MEMORY)))
    assert MotionFile(str(path)).read() == MEMORY
    assert MotionFile(str(path), 'sim_1').read() is None


def test_a_file_of_before_records_told_more_is_read(tmp_path):
    """Otherwise an owed stop would be forgotten when the software is updated."""
    memory, path = replace(MEMORY, records=(STOP,)), tmp_path / 'motion.json'
    content = to_json(memory)
    for name in ('ending', 'acknowledged_by', 'doubt', 'verb', 'stands_for', 'is_cancelled'):
        del content['records'][0][name]
    path.write_text(json.dumps(content))
    assert MotionFile(str(path)).read() == memory


@pytest.mark.parametrize('text', ['', '{', '[]', '7', '{"epoch": 1}', '{"epoch": 1, "records": 3}'])
def test_what_cannot_be_read_is_told_and_is_nothing(tmp_path, monkeypatch, text):
    told = []
    monkeypatch.setattr(rospy, 'logwarn', lambda *words: told.append(words))
    path = tmp_path / 'motion.json'
    path.write_text(text)
    assert MotionFile(str(path)).read() is None
    assert told


def test_a_file_that_cannot_be_written_holds_nobody_up(tmp_path, monkeypatch):
    told = []
    monkeypatch.setattr(controller_motion, 'warn', lambda *words: told.append(words))
    (tmp_path / 'file').write_text('')
    MotionFile(str(tmp_path / 'file' / 'motion.json')).keep(MEMORY)
    assert told


@pytest.fixture
def warned(monkeypatch):
    told = []
    monkeypatch.setattr(controller_motion, 'warn', lambda kind, words: told.append(words))
    return told


EARLIER = replace(MEMORY, epoch=5, records=(DRIVE,))


def test_on_a_disk_without_room_the_newest_memory_takes_the_room_of_the_one_before(
        on_small_disk, warned):
    def act(disk):
        path = str(disk.folder / 'motion.json')
        file = MotionFile(path)
        file.keep(EARLIER)
        with disk.full():
            file.keep(MEMORY)
            return MotionFile(path).read()
    assert on_small_disk(act) == MEMORY
    assert not warned


def test_a_memory_that_could_not_be_replaced_is_not_there_when_the_disk_has_room_again(
        on_small_disk, warned, monkeypatch):
    """With the old file, a restarted controller would let a program drive after a person's stop."""
    def act(disk):
        path = str(disk.folder / 'motion.json')
        file = MotionFile(path)
        file.keep(EARLIER)

        def fails(*_):
            raise OSError(28, 'No space left on device')
        with monkeypatch.context() as patch:
            patch.setattr(controller_motion, 'replace_json', fails)
            file.keep(MEMORY)
        missing = MotionFile(path).read()
        file.keep(MEMORY)
        return missing, MotionFile(path).read()
    assert on_small_disk(act) == (None, MEMORY)
    assert len(warned) == 1 and 'No space left on device' in warned[0]


def test_of_a_memory_on_a_disk_that_has_become_read_only_only_an_owed_stop_counts(
        on_small_disk, warned):
    """No giver may continue in an epoch that may have ended long ago."""
    def act(disk):
        path = str(disk.folder / 'motion.json')
        file = MotionFile(path)
        file.keep(replace(MEMORY, epoch=5))
        with disk.read_only():
            file.keep(EARLIER)
            return MotionFile(path).read()
    known = on_small_disk(act)
    assert (known.epoch, known.previous_epoch, known.stop_owed) == (0, 0, True)
    assert 'Read-only file system' in warned[0] and 'its folder is read-only' in warned[1]


def test_everybody_is_told_in_the_words_of_the_message():
    told = message_of(RobotMotion(MEMORY, MotionState.STOPPING, True))
    assert (told.epoch, told.previous_epoch, told.foreign_epoch, told.giver, told.state, told.goal,
            told.stop_owed, told.cause, told.reason, told.emergency_stop) == (
                2 ** 64 - 1, 7, 6, '/bridge', msg.Motion.STOPPING, '', True, msg.Motion.STOP,
                '"stop" of /rviz', True)


@pytest.mark.parametrize('kind', [MotionCause, MotionState])
def test_the_constants_are_those_of_the_message(kind):
    for one in kind:
        assert getattr(msg.Motion, one.name) == one


def test_the_last_commands_are_told_with_the_constants_of_their_message():
    last, = message_of(RobotMotion(MEMORY, MotionState.STOPPING, False)).last_commands
    assert (last.giver, last.number, last.fate, last.foreign_epoch) == (
        '/bridge', 2 ** 41, msg.LastCommand.FAILED, 2 ** 63)
    for fate in CommandFate:
        assert getattr(msg.LastCommand, fate.name) == fate
