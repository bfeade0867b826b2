"""Initializes a node even if its log cannot be written, as on a disk that is full or read-only.

rospy ends a program if it cannot open the program's log file. It also raises an error if it cannot
write to a standard stream.
"""
from __future__ import annotations

import logging
import logging.handlers
import os
import sys
import tempfile
from contextlib import contextmanager, suppress
from typing import Any, Callable, Iterator

import rospkg
import rospy
from rospy.impl.paramserver import get_param_server_cache

from node_lifecycle import bounded_messages, topic_connections
from node_program.inert_text import entry
from xmlrpc_guard import guard_servers

_FILE_HANDLER = 'RotatingFileHandler'  # the class of logging.handlers that rospy's log uses
_TOPICS_LEFT_OUT = '/rosout_disable_topics_generation'


def init_node(name: str, **options: Any) -> None:
    """Calls rospy.init_node. If no log file can be made, the node has none.

    From now on the node refuses requests of web browsers, and messages that are too large.
    """
    topic_connections.mend()
    bounded_messages.limit_messages()
    guard_servers()
    with _possible_log_file():
        rospy.init_node(name, **options)
    _ask_once()
    for handler in logging.getLogger('rosout').handlers:
        handler.addFilter(_bounded)
        _guard(handler, 'emit', _harmless)
    for handler in logging.getLogger().handlers:  # they print a traceback if a log line fails
        handler.addFilter(_bounded)
        _guard(handler, 'handleError', _but_for_disks)


def _bounded(record: logging.LogRecord) -> bool:
    """Shortens an entry and escapes its control characters. This is a filter for handlers."""
    if not getattr(record, 'is_bounded', False):  # all handlers get the same record
        with suppress(TypeError, ValueError):  # a wrong format: the handler reports it
            record.msg, record.args = entry(record.getMessage()), ()
        record.is_bounded = True
    return True


def _ask_once() -> None:
    """Caches a parameter that rospy reads from the master at every log line.

    A node must be able to log even if there is no master, or if the master does not answer.
    """
    get_param_server_cache().set(_TOPICS_LEFT_OUT, bool(rospy.get_param(_TOPICS_LEFT_OUT, False)))


class _NoFile(logging.NullHandler):
    """Replaces rospy's log file."""

    def __init__(self, *_: object) -> None:
        super().__init__()


@contextmanager
def _possible_log_file() -> Iterator[None]:
    """Provides a context in which rospy makes no log file if such a file cannot be opened.

    Without a folder for the file, rospy would set up no log at all. Then the node could not even
    report on its console why it cannot work. So rospy gets a folder that exists, but writes nothing
    there.
    """
    folder = rospkg.get_log_dir()
    try:
        os.makedirs(folder, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        print(f'There is no log file in {folder} ({error.strerror}): this node logs on its console '
              f'and on /rosout only. Set ROS_LOG_DIR to a folder that it can write.',
              file=sys.stderr)
        file_handler = getattr(logging.handlers, _FILE_HANDLER)
        setattr(logging.handlers, _FILE_HANDLER, _NoFile)
        variable = os.environ.get(rospkg.environment.ROS_LOG_DIR)
        os.environ[rospkg.environment.ROS_LOG_DIR] = os.sep
        try:
            yield
        finally:
            setattr(logging.handlers, _FILE_HANDLER, file_handler)
            if variable is None:
                del os.environ[rospkg.environment.ROS_LOG_DIR]
            else:
                os.environ[rospkg.environment.ROS_LOG_DIR] = variable
    else:
        yield


_Handle = Callable[[logging.LogRecord], None]


def _guard(handler: logging.Handler, method: str, guard: Callable[[_Handle], _Handle]) -> None:
    """Wraps a method of a handler. The handlers belong to rospy, so only methods are replaced."""
    setattr(handler, method, guard(getattr(handler, method)))


def _but_for_disks(handle_error: _Handle) -> _Handle:
    def guarded(record: logging.LogRecord) -> None:
        if not isinstance(sys.exc_info()[1], OSError):
            handle_error(record)
    return guarded


def _harmless(emit: _Handle) -> _Handle:
    def guarded(record: logging.LogRecord) -> None:
        with suppress(OSError):
            emit(record)
    return guarded
