"""Another program can recognise the line that a node logs when it is ready."""
from __future__ import annotations

import io
import logging
import re

import pytest
import rospy
from rosgraph.roslogging import RosStreamHandler

from node_lifecycle.ready_line import announce_ready
from node_program.screen_lines import FORM, READY


def test_the_line_that_says_what_is_ready_has_a_logger_of_its_own(
        monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('ROSCONSOLE_FORMAT', FORM)
    screen, logger = io.StringIO(), logging.getLogger('rosout')
    handler, level = RosStreamHandler(colorize=False, stdout=screen, stderr=screen), logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        announce_ready('8 robots are 100 % ready.')
        rospy.loginfo('Ready: 8 robots.')
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
    found = [re.fullmatch(r'\[INFO\] \[[\d.]+\] \[(.*)\] \S*: (.*)', line)
             for line in screen.getvalue().splitlines()]
    assert [one and one.groups() for one in found] == [
        (f'rosout.{READY}', '8 robots are 100 % ready.'), ('rosout', 'Ready: 8 robots.')]
