"""A disk too full for the log is no reason for a node to end."""
from __future__ import annotations

import logging

import pytest

from node_lifecycle.startup import _survive_a_full_log


class FullDisk(logging.Handler):
    """A handler as rospy's for the standard streams: it lets errors out."""

    def emit(self, record):
        raise OSError(28, 'No space left on device')


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
    _survive_a_full_log()
    logger.error('after')
    assert said == ['after']
