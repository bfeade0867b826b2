"""Periodic work goes on even if ROS time stands still or steps; a node then reports its clock."""
from __future__ import annotations

import logging
import threading
from typing import Iterator, List

import genpy
import pytest
import rospy
from rospy import rostime

from node_lifecycle.periodic import Periodic

PERIOD = 0.01  # s


@pytest.fixture
def simulated_time() -> Iterator[None]:
    """Sets ROS time as under /use_sim_time: it stands still at 0 until a test moves it."""
    rostime.switch_to_wallclock()
    rostime.set_rostime_initialized(True)
    rostime._set_rostime(genpy.Time(0))
    yield
    rostime.switch_to_wallclock()
    rostime.set_rostime_initialized(False)


@pytest.fixture
def calls() -> Iterator[threading.Semaphore]:
    """Yields a semaphore that is released at each call."""
    called = threading.Semaphore(0)
    periodic = Periodic('test', PERIOD, called.release)
    yield called
    periodic.shutdown()


def are_made(calls: threading.Semaphore, number: int = 3) -> bool:
    return all(calls.acquire(timeout=10.0) for _ in range(number))


def test_periodic_work_goes_on_while_ros_time_stands_still(simulated_time, calls):
    assert are_made(calls)


def test_periodic_work_goes_on_after_ros_time_has_stepped_back(simulated_time, calls):
    rostime._set_rostime(genpy.Time(1000))
    assert are_made(calls)
    rostime._set_rostime(genpy.Time(1))
    assert are_made(calls)


def test_a_call_that_fails_is_logged_and_does_not_end_the_work(said):
    called = threading.Semaphore(0)

    def fail() -> None:
        called.release()
        raise KeyError('vertex 7')
    periodic = Periodic('drawing', PERIOD, fail)
    assert are_made(called)
    end(periodic)
    assert '"drawing"' in said[0] and "KeyError: 'vertex 7'" in said[0]


def test_a_call_that_fails_because_the_node_ends_is_not_logged(said):
    done = threading.Event()

    def fail() -> None:
        periodic.shutdown()
        done.set()
        raise rospy.ROSException('publish() to a closed topic')
    periodic = Periodic('drawing', PERIOD, fail)
    assert done.wait(10.0)
    end(periodic)
    assert said == []


def end(periodic: Periodic) -> None:
    periodic.shutdown()
    for thread in threading.enumerate():
        if thread.name == 'drawing':
            thread.join(10.0)


@pytest.fixture
def said() -> Iterator[List[str]]:
    """Yields the lines of the node's log."""
    logger, lines = logging.getLogger('rosout'), []
    handler = logging.Handler()
    handler.emit = lambda record: lines.append(record.getMessage())
    logger.addHandler(handler)
    yield lines
    logger.removeHandler(handler)
