"""The log messages of a node that ends."""
from __future__ import annotations

import logging
import threading

import pytest

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
