"""If the ROS time of a node stands still or steps back, the node reports the clock."""
from __future__ import annotations

import logging
from typing import Iterator, List

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from node_lifecycle.clock_watch import STILL, ClockWatch


class Clocks:
    """A node's two clocks, and the statuses that its diagnostics publish."""

    def __init__(self) -> None:
        self.ros, self.monotonic = 0.0, 100.0
        self.watch = ClockWatch(lambda: self.ros, lambda: self.monotonic)

    def status(self, after: float, ros: float) -> DiagnosticStatus:
        """Returns the status `after` s later, when the ROS time is `ros`."""
        self.monotonic += after
        self.ros = ros
        status = DiagnosticStatusWrapper()
        self.watch.diagnose(status)
        return status


@pytest.fixture
def said() -> Iterator[List[str]]:
    logger, lines = logging.getLogger('rosout'), []
    handler, level = logging.Handler(), logger.level
    handler.emit = lambda record: lines.append(record.getMessage())
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    yield lines
    logger.removeHandler(handler)
    logger.setLevel(level)


def test_a_node_that_waits_for_the_clock_says_so_once_in_its_log_and_always_in_its_status(said):
    clocks = Clocks()
    assert clocks.status(after=STILL - 1, ros=0.0).level == DiagnosticStatus.OK
    for _ in range(3):
        status = clocks.status(after=1, ros=0.0)
        assert status.level == DiagnosticStatus.ERROR
        assert '/use_sim_time is true, and no /clock came' in status.message
        assert 'rosparam set /use_sim_time false' in status.message
    assert len(said) == 1 and 'no /clock came' in said[0]


def test_ros_time_that_stops_is_named_and_its_going_on_too(said):
    clocks = Clocks()
    assert clocks.status(after=1, ros=50.0).level == DiagnosticStatus.OK
    status = clocks.status(after=STILL, ros=50.0)
    assert status.level == DiagnosticStatus.ERROR
    assert 'stands still at 50.000 s' in status.message
    assert clocks.status(after=1, ros=50.5).level == DiagnosticStatus.OK
    assert ['stands still' in said[0], 'moves on again' in said[1]] == [True, True]


def test_ros_time_that_steps_back_is_named(said):
    clocks = Clocks()
    clocks.status(after=1, ros=50.0)
    assert clocks.status(after=1, ros=2.0).level == DiagnosticStatus.OK
    assert 'stepped back from 50.000 s to 2.000 s' in said[0]
