"""What is known of the motion outlives the process, and everybody is told of it."""
from __future__ import annotations

import pytest
import rospy

from omron_arcl.execution import Giver
from omron_arcl.motion_authority import Cause, Memory, Motion, MotionState
from omron_ld90.nodes import controller_motion
from omron_ld90.nodes.controller_motion import MotionFile, message_of
from omron_ld90_msgs import msg

MEMORY = Memory(2 ** 64 - 1, 7, Giver('/bridge', 'http://host:1/'), Cause.STOP, '"stop" of /rviz',
                '12', False, True, ('12', '13'), ('13',))


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


@pytest.mark.parametrize('text', ['', '{', '[]', '7', '{"epoch": 1}', '{"epoch": 1, "giver": 3}'])
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


def test_everybody_is_told_in_the_words_of_the_message():
    told = message_of(Motion(MEMORY, MotionState.STOPPING))
    assert (told.epoch, told.previous_epoch, told.giver, told.state, told.goal, told.stop_owed,
            told.cause, told.reason) == (2 ** 64 - 1, 7, '/bridge', msg.Motion.STOPPING, '12', True,
                                         msg.Motion.STOP, '"stop" of /rviz')


@pytest.mark.parametrize('kind', [Cause, MotionState])
def test_the_constants_are_those_of_the_message(kind):
    for one in kind:
        assert getattr(msg.Motion, one.name) == one
