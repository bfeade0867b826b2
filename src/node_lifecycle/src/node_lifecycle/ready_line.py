"""Logs a line that says what is ready, so that people know when they may begin."""
from __future__ import annotations

import rospy

from node_program.screen_lines import READY


def announce_ready(words: str) -> None:
    """Logs what is ready and what a person can do. Programs recognise the line by its logger."""
    rospy.loginfo('%s', words, logger_name=READY)
