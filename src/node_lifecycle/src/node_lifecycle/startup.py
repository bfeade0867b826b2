"""How a node starts and ends, and what watches it meanwhile.

Under `respawn` a node that exits on a wrong configuration would come back for ever. So it stays: it
logs once what is wrong, shows it as ERROR in /diagnostics, and waits for its restart. Every node
waits for its ROS master, is watched for threads that stand still, and registers anew with a master
that was restarted, its parameters included.
"""
from __future__ import annotations

import logging
import os
import signal
import sys
import threading
import time
from typing import Any, Callable, Tuple

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticStatus

import node_program
from node_lifecycle import log_file
from node_lifecycle.diagnostics import Task, publish_diagnostics
from node_lifecycle.kept_parameters import KEPT
from node_lifecycle.master_watch import watch_master
from node_lifecycle.parameters import ConfigurationError
from node_lifecycle.watchdog import Watchdog

MASTER_PERIOD = 0.3  # s between two looks for a ROS master
END_WITHIN = 3.0  # s from SIGINT or SIGTERM to the end of the process, regardless of rospy


def run(name: str, start: Callable[[], Any],
        misconfigured: Callable[[str], Any] = lambda reason: None,
        libraries: Tuple[str, ...] = (), written: Tuple[str, ...] = ()) -> None:
    """Run a node: `start` reads parameters, builds objects and connects callbacks; then wait.

    What `start` returns is kept alive, and its `close()`, if it has one, is called at shutdown.
    `misconfigured` is called with the reason when `start` raises ConfigurationError: there a node
    tells of it on topics of its own; what it returns is kept alive. The threads of the package that
    `start` belongs to are watched, and those of its `libraries`. A new ROS master gets
    what `parameter` reads and all private parameters, but those `written` by the node itself.
    """
    init_node(name)
    KEPT.keep(rospy.get_name(), rospy.get_param(rospy.get_name(), {}),
              but=tuple(map(rospy.resolve_name, written)))
    ending = threading.Event()
    rospy.on_shutdown(ending.set)
    _end_quietly(ending)
    Watchdog((start.__module__.split('.')[0], *libraries))
    watch_master()
    try:
        node = start()
    except ConfigurationError as error:
        rospy.logerr('%s cannot work: %s Mend it and restart the node.', rospy.get_name(), error)
        publish_diagnostics('none', {'configuration': _wrong(str(error))})
        node = misconfigured(str(error))
    else:
        if hasattr(node, 'close'):
            rospy.on_shutdown(node.close)
    node_program.tell_started()
    _wait_for_end(ending)


def init_node(name: str) -> None:
    """Become a node as soon as there is a ROS master; ended by SIGINT and SIGTERM from now on.

    For nodes that cannot leave their main thread to `run`, like those with a window.
    """
    _end_on_signals()
    _wait_for_master()
    try:
        log_file.init_node(name, disable_signals=True)
    except rospy.ROSInitException:
        if rospy.is_shutdown():
            os._exit(0)  # ended before it had begun: rospy's server threads would stay for ever
        raise


def _wait_for_master() -> None:
    """rospy gives up where it has parameters to set and the ROS master is not there yet."""
    uri, told = rosgraph.get_master_uri(), False
    while not rosgraph.is_master_online():
        if rospy.is_shutdown():
            os._exit(0)
        if not told:
            print(f'There is no ROS master at {uri} yet: waiting for it.', file=sys.stderr)
            told = True
        time.sleep(MASTER_PERIOD)


def _wrong(reason: str) -> Task:
    """Says what is wrong for as long as the node waits to be restarted."""
    return lambda status: status.summary(DiagnosticStatus.ERROR, reason)


def _end_on_signals() -> None:
    """Shut down in a thread of its own, and in any case within END_WITHIN seconds.

    rospy's own handlers do it inside the code that the signal interrupts, which may hold the very
    lock that they wait for; and rospy can lock itself up when it is ended while it registers. About
    one node in forty then hung when it was ended while starting.
    """
    def end(number: int, _frame: Any) -> None:
        threading.Thread(target=rospy.signal_shutdown, args=(f'signal {number}',),
                         daemon=True).start()
        last_resort = threading.Timer(END_WITHIN, os._exit, (1,))
        last_resort.daemon = True
        last_resort.start()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)


def _end_quietly(ending: threading.Event) -> None:
    """A callback that publishes while rospy ends is no error: topics close before is_shutdown()."""
    logging.getLogger('rosout').addFilter(
        lambda record: not (ending.is_set() and 'to a closed topic' in record.getMessage()))


def _wait_for_end(ending: threading.Event) -> None:
    """Until rospy has taken leave of the master; rospy.spin looks for that only twice a second."""
    while not rospy.is_shutdown():
        if ending.wait(0.5):
            rospy.rostime.wallsleep(0.01)
