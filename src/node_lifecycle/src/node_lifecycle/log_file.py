"""Becoming a node, even where the log cannot be written: a full or read-only disk ends no node.

rospy ends a program whose log file it cannot open, and lets errors of the standard streams out.
"""
from __future__ import annotations

import logging
import logging.handlers
import sys
import tempfile
from contextlib import contextmanager, suppress
from typing import Any, Callable, Iterator

import rospkg
import rospy
from rospy.impl.paramserver import get_param_server_cache

from node_lifecycle import topic_connections

_FILE_HANDLER = 'RotatingFileHandler'  # of logging.handlers: what rospy writes its log with
_TOPICS_LEFT_OUT = '/rosout_disable_topics_generation'


def init_node(name: str, **options: Any) -> None:
    """rospy.init_node; without a log file where there can be none."""
    topic_connections.mend()
    with _possible_log_file():
        rospy.init_node(name, **options)
    _ask_once()
    for handler in logging.getLogger('rosout').handlers:
        _guard(handler, 'emit', _harmless)
    for handler in logging.getLogger().handlers:  # they print a traceback for each message
        _guard(handler, 'handleError', _but_for_disks)


def _ask_once() -> None:
    """rospy asks the master at every line of the log; without a master, or with one that hangs, a
    node must be able to log."""
    get_param_server_cache().set(_TOPICS_LEFT_OUT, bool(rospy.get_param(_TOPICS_LEFT_OUT, False)))


class _NoFile(logging.NullHandler):
    """Stands for rospy's log file."""

    def __init__(self, *_: object) -> None:
        super().__init__()


@contextmanager
def _possible_log_file() -> Iterator[None]:
    """Within it what makes a log file makes none, if that could not be opened."""
    folder = rospkg.get_log_dir()
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except FileNotFoundError:
        yield  # rospy makes it, or says itself that it cannot
    except OSError as error:
        print(f'There is no log file in {folder} ({error.strerror}).', file=sys.stderr)
        file_handler = getattr(logging.handlers, _FILE_HANDLER)
        setattr(logging.handlers, _FILE_HANDLER, _NoFile)
        try:
            yield
        finally:
            setattr(logging.handlers, _FILE_HANDLER, file_handler)
    else:
        yield


_Handle = Callable[[logging.LogRecord], None]


def _guard(handler: logging.Handler, method: str, guard: Callable[[_Handle], _Handle]) -> None:
    """Handlers are rospy's; so their methods are replaced, one by one."""
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
