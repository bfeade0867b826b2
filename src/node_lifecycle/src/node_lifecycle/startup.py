"""Starts and ends a node, and starts its watchers.

Under `respawn`, a node that exits because of a wrong configuration would be restarted for ever. So
such a node keeps running: it logs the error once, shows it as ERROR in /diagnostics, and waits for
its restart. Every node waits for its ROS master. A watchdog looks for blocked threads. If the
master is restarted, the node registers itself and its parameters there again.
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
from node_lifecycle.clock_watch import watch_clock
from node_lifecycle.diagnostics import Task, publish_diagnostics
from node_lifecycle.kept_parameters import KEPT
from node_lifecycle.master_watch import watch_master
from node_lifecycle.parameters import ConfigurationError
from node_lifecycle.watchdog import Watchdog

MASTER_PERIOD = 0.3  # s between two checks for a ROS master
END_WITHIN = 3.0  # s after SIGINT or SIGTERM within which the process ends, even if rospy hangs


def run(name: str, start: Callable[[], Any],
        misconfigured: Callable[[str], Any] = lambda reason: None,
        libraries: Tuple[str, ...] = (), written: Tuple[str, ...] = ()) -> None:
    """Runs a node. `start` reads parameters, builds objects and connects callbacks. Then waits.

    The result of `start` is kept alive. If it has a `close()`, this is called at shutdown.
    If `start` raises ConfigurationError, `misconfigured` is called with the reason, so that a node
    can report the reason on its own topics; the result of `misconfigured` is kept alive, too. The
    watchdog watches the threads in the package of `start` and in `libraries`. A new ROS master gets
    the parameters that `parameter` has read, and all private parameters except those in `written`,
    which the node itself writes.
    """
    init_node(name)
    KEPT.keep(rospy.get_name(), rospy.get_param(rospy.get_name(), {}),
              but=tuple(map(rospy.resolve_name, written)))
    ending = threading.Event()
    rospy.on_shutdown(ending.set)
    _end_quietly(ending)
    Watchdog((start.__module__.split('.')[0], *libraries))
    watch_master()
    watch_clock()
    try:
        check_namespace(rospy.get_namespace())
        node = start()
    except ConfigurationError as error:
        rospy.logerr('%s cannot work: %s Correct this and restart the node.', rospy.get_name(),
                     error)
        publish_diagnostics('none', {'configuration': _wrong(str(error))})
        node = misconfigured(str(error))
    except Exception:
        if not ending.is_set():
            raise
        os._exit(0)  # the node ended during its start, so its topics or its master are gone
    else:
        if hasattr(node, 'close'):
            rospy.on_shutdown(node.close)
    node_program.node_started()
    _wait_for_end(ending)


def init_node(name: str) -> None:
    """Initializes a node as soon as there is a ROS master; SIGINT and SIGTERM end it from now on.

    It is for nodes whose main thread cannot run `run`, e.g. nodes with a window.
    """
    _end_on_signals()
    _wait_for_master()
    try:
        log_file.init_node(name, disable_signals=True)
    except rospy.ROSInitException:
        if rospy.is_shutdown():
            os._exit(0)  # otherwise rospy's server threads would run for ever
        raise


def check_namespace(namespace: str) -> None:
    """Raises ConfigurationError for a namespace within a namespace.

    A node has relative names, which begin with its namespace, and absolute names, such as /graph.
    Other programs look for its relative names at one level, such as under the robot's name.
    """
    levels = namespace.strip('/').split('/')
    if len(levels) > 1:
        raise ConfigurationError(
            f'its namespace is {namespace.rstrip("/")}, so neither a fleet manager nor the tools '
            f'of RViz reach /{levels[-1]}: unset ROS_NAMESPACE in the shell that starts the launch '
            'file, and include the file in no <group ns="...">.')


def _wait_for_master() -> None:
    """Waits for the ROS master: without a master, rospy fails when it must set parameters."""
    uri, told = rosgraph.get_master_uri(), False
    while not rosgraph.is_master_online():
        if rospy.is_shutdown():
            os._exit(0)
        if not told:
            print(f'There is no ROS master at {uri} yet: waiting for it.', file=sys.stderr)
            told = True
        time.sleep(MASTER_PERIOD)


def _wrong(reason: str) -> Task:
    """Returns a task that reports the error while the node waits for its restart."""
    return lambda status: status.summary(DiagnosticStatus.ERROR, reason)


def _end_on_signals() -> None:
    """Makes signals shut down the node in a separate thread, and end it within END_WITHIN seconds.

    rospy's own handlers shut down inside the interrupted code. If that code holds the lock for
    which a handler waits, the node hangs. rospy can also deadlock if it is ended while it
    registers: about one node in forty hung when it was ended during its start.
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
    """Drops errors of callbacks and threads that use ROS while the node ends.

    Topics close before is_shutdown() is true. So no thread knows in time that it must not publish.
    """
    logging.getLogger('rosout').addFilter(
        lambda record: not (ending.is_set() and 'to a closed topic' in record.getMessage()))
    report = threading.excepthook

    def report_unless_ending(args: Any) -> None:
        if not (ending.is_set() and isinstance(args.exc_value, rospy.ROSException)):
            report(args)
    threading.excepthook = report_unless_ending


def _wait_for_end(ending: threading.Event) -> None:
    """Waits until rospy has unregistered the node; rospy.spin notices this only after up to 0.5 s.
    """
    while not rospy.is_shutdown():
        if ending.wait(0.5):
            rospy.rostime.wallsleep(0.01)
