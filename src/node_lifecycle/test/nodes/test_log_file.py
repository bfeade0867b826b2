"""A full or read-only disk for the log does not end a node."""
from __future__ import annotations

import errno
import logging
import logging.handlers
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import rosgraph.xmlrpc
from rospy.impl import tcpros_base
from rospy.impl.paramserver import ParamServerCache
from rospy.impl.tcpros_pubsub import TCPROSSub

from node_lifecycle import log_file
from xmlrpc_guard import GuardedRequestHandler


class FullDisk(logging.Handler):
    """A handler that raises errors, like rospy's handler for the standard streams."""

    def emit(self, record):
        raise OSError(errno.ENOSPC, 'No space left on device')


@pytest.fixture(autouse=True)
def master(monkeypatch):
    """Replaces the ROS master, and rospy's cache of parameters by an empty one."""
    asked, cache = [], ParamServerCache()
    monkeypatch.setattr(log_file.rospy, 'init_node', lambda name, **options: None)
    monkeypatch.setattr(log_file.rospy, 'get_param',
                        lambda name, default: asked.append(name) or default)
    monkeypatch.setattr(log_file, 'get_param_server_cache', lambda: cache)
    return SimpleNamespace(asked=asked, cache=cache)


@pytest.fixture
def logger():
    logger = logging.getLogger('rosout')
    before, logger.handlers = logger.handlers, [FullDisk()]
    yield logger
    logger.handlers = before


def test_what_cannot_be_logged_is_left_out_and_the_next_handler_has_it(logger):
    with pytest.raises(OSError, match='No space'):
        logger.error('before')
    said = []
    other = logging.Handler()
    other.emit = lambda record: said.append(record.getMessage())
    logger.addHandler(other)
    log_file.init_node('node')
    logger.error('after')
    assert said == ['after']


def test_a_log_file_that_is_full_says_nothing_but_a_wrong_message_does(monkeypatch, capsys):
    class Fails(logging.Handler):
        def __init__(self, error):
            super().__init__()
            self.error = error

        def emit(self, record):
            try:
                raise self.error
            except (OSError, TypeError):
                self.handleError(record)

    root = logging.getLogger()
    monkeypatch.setattr(root, 'handlers', [Fails(OSError(errno.ENOSPC, 'NO SPACE')),
                                           Fails(TypeError('not all arguments converted'))])
    log_file.init_node('node')
    root.error('after')
    said = capsys.readouterr().err
    assert 'NO SPACE' not in said and 'not all arguments converted' in said


def opens_a_log(path):
    """Returns a function that opens a log as rospy does: by the name of the handler's class."""
    return lambda name, **options: logging.handlers.RotatingFileHandler(str(path), 'a', 1000, 4)


@pytest.mark.parametrize('error', [errno.ENOSPC, errno.EROFS, errno.EACCES])
def test_where_no_log_file_can_be_opened_there_is_a_node_without_one(
        tmp_path, monkeypatch, capsys, error):
    def full(**_):
        raise OSError(error, 'no')
    file = tmp_path / 'full' / 'node.log'
    monkeypatch.setattr(log_file.rospy, 'init_node', opens_a_log(file))
    monkeypatch.setattr(log_file.tempfile, 'TemporaryFile', full)
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path))
    log_file.init_node('node')
    assert f'There is no log file in {tmp_path} (no)' in capsys.readouterr().err
    assert os.environ['ROS_LOG_DIR'] == str(tmp_path)
    monkeypatch.undo()
    assert logging.handlers.RotatingFileHandler is not log_file._NoFile


LOGS_AN_ERROR = """
import logging
from rosgraph import roslogging
from node_lifecycle import log_file
with log_file._possible_log_file():
    roslogging.configure_logging('rospy', filename='node.log')
logging.getLogger('rosout').error('the node cannot work')
"""


@pytest.mark.parametrize('folder', ['/proc/nowhere', '/dev/null', '/dev/null/log'])
def test_a_node_whose_log_folder_cannot_be_made_says_so_and_still_logs_on_its_console(folder):
    """This happens for a user without a home, and on a read-only root."""
    result = subprocess.run([sys.executable, '-c', LOGS_AN_ERROR], text=True, check=True,
                            env={**os.environ, 'ROS_LOG_DIR': folder}, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, timeout=60)
    assert f'There is no log file in {folder} (' in result.stdout
    assert 'Set ROS_LOG_DIR to a folder that it can write' in result.stdout
    assert 'the node cannot work' in result.stdout


def test_where_a_log_file_can_be_opened_it_is(tmp_path, monkeypatch, capsys):
    file = tmp_path / 'node.log'
    monkeypatch.setattr(log_file.rospy, 'init_node', opens_a_log(file))
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path))
    log_file.init_node('node')
    assert file.exists() and capsys.readouterr().err == ''


def test_the_master_is_asked_once_what_a_line_of_the_log_holds(master):
    log_file.init_node('node')
    assert [master.cache.get(name) for name in master.asked] == [False]


def test_a_node_has_closed_its_doors_before_it_opens_a_port(monkeypatch):
    doors = []
    monkeypatch.setattr(log_file.rospy, 'init_node', lambda name, **options: doors.append(
        (rosgraph.xmlrpc.SilenceableXMLRPCRequestHandler, TCPROSSub.read_messages,
         tcpros_base.read_ros_handshake_header)))
    log_file.init_node('node')
    (handler, read_messages, read_header), = doors
    assert handler is GuardedRequestHandler
    assert hasattr(read_messages, '__wrapped__') and hasattr(read_header, '__wrapped__')


def test_every_program_initialises_its_node_so():
    sources = Path(__file__).resolve().parents[3]
    own = {file.name for file in sources.glob('*/src/**/*.py')
           if re.search(r'rospy\.init_node\(|rospy import .*init_node', file.read_text())}
    assert own == {'log_file.py'}
