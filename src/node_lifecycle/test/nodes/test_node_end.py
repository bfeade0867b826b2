"""The log messages of a node that ends."""
from __future__ import annotations

import logging
import threading

import pytest
import rospy

from node_lifecycle import startup
from node_lifecycle.startup import _end_quietly

CLOSED = 'bad callback: ... ROSException: publish() to a closed topic'


@pytest.fixture
def said():
    logger, records = logging.getLogger('rosout'), []
    handler, filters = logging.Handler(), list(logger.filters)
    handler.emit = lambda record: records.append(record.getMessage())
    logger.addHandler(handler)
    yield records
    logger.removeHandler(handler)
    logger.filters = filters


def test_a_topic_that_is_closed_is_an_error_only_until_the_node_ends(said):
    ending = threading.Event()
    _end_quietly(ending)
    logging.getLogger('rosout').error(CLOSED)
    ending.set()
    logging.getLogger('rosout').error(CLOSED)
    logging.getLogger('rosout').error('bad callback: ... KeyError')
    assert said == [CLOSED, 'bad callback: ... KeyError']


def thread_that_raises(error: Exception) -> None:
    def work() -> None:
        raise error
    thread = threading.Thread(target=work)
    thread.start()
    thread.join(10)


def test_a_thread_that_publishes_while_the_node_ends_prints_no_traceback(said, monkeypatch):
    reported, ending = [], threading.Event()  # `reported`: errors that would print a traceback
    monkeypatch.setattr(threading, 'excepthook', lambda args: reported.append(args.exc_value))
    closed = rospy.ROSException('publish() to a closed topic')
    _end_quietly(ending)
    thread_that_raises(closed)
    assert reported == [closed], 'before the end it is a defect'
    ending.set()
    thread_that_raises(closed)
    thread_that_raises(KeyError('a defect'))
    assert [str(error) for error in reported[1:]] == ["'a defect'"]


@pytest.mark.parametrize('is_ending', [True, False])
def test_a_node_that_is_ended_during_its_start_prints_no_traceback(monkeypatch, is_ending):
    hooks, ended = [], []

    def stop(status: int) -> None:
        ended.append(status)
        raise SystemExit(status)

    def start() -> None:
        if is_ending:
            hooks[0]()
        raise rospy.ROSException('the topic was closed')
    for name in ('init_node', 'Watchdog', 'watch_master', 'watch_clock', 'check_namespace'):
        monkeypatch.setattr(startup, name, lambda *_: None)
    monkeypatch.setattr(startup.rospy, 'get_param', lambda *_: {})
    monkeypatch.setattr(startup.rospy, 'on_shutdown', hooks.append)
    monkeypatch.setattr(startup.os, '_exit', stop)
    with pytest.raises(SystemExit if is_ending else rospy.ROSException):
        startup.run('node', start)
    assert ended == ([0] if is_ending else [])
