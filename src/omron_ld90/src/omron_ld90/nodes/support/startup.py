"""How every node starts: parameters are read strictly; a wrong one is logged and reported.

Under `respawn` a node that exits on a wrong configuration would come back for ever. So it stays: it
logs once what is wrong, shows it as ERROR in /diagnostics, and waits for its restart. Every node
is watched for threads that stand still, and registers anew with a ROS master that was restarted.
"""
from __future__ import annotations

import logging
import math
import os
import signal
import threading
from typing import Any, Callable, Tuple, Type

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from omron_ld90.nodes.support import master_watch, watchdog
from omron_ld90.nodes.support.diagnostics import Task, publish_diagnostics

REQUIRED = object()
END_WITHIN = 3.0  # s from SIGINT or SIGTERM to the end of the process, whatever rospy does


class ConfigurationError(Exception):
    """A parameter that the node cannot work with; the text says which one and what to do."""


def parameter(name: str, default: Any = REQUIRED, kind: Type = str) -> Any:
    """The parameter `name` (e.g. `~robot_ip`) as `kind`; strict, but an int will do for a float.

    Raises ConfigurationError when it is missing without a default, or of another type. `kind=str`
    accepts numbers too, because roslaunch turns `password:=1234` into one.
    """
    resolved = rospy.resolve_name(name)
    value = rospy.get_param(name, default)
    if value is REQUIRED:
        raise ConfigurationError(f'Parameter {resolved} is missing: set it in the launch file.')
    if kind is str and isinstance(value, (int, float)) and not isinstance(value, bool):
        return str(value)
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise ConfigurationError(
            f'Parameter {resolved} is {value!r}, but must be of type {kind.__name__}.')
    return value


def number(name: str, default: float, minimum: float = -math.inf,
           maximum: float = math.inf) -> float:
    """A float parameter within `minimum`..`maximum`; raises ConfigurationError outside, on nan."""
    value = parameter(name, default, float)
    if not minimum <= value <= maximum:
        raise ConfigurationError(
            f'Parameter {rospy.resolve_name(name)} is {value}, but must lie in '
            f'{minimum}..{maximum}.')
    return value


def choice(name: str, default: str, allowed: Tuple[str, ...]) -> str:
    """A string parameter that must be one of `allowed`."""
    value = parameter(name, default, str)
    if value not in allowed:
        raise ConfigurationError(
            f'Parameter {rospy.resolve_name(name)} is {value!r}, '
            f'but must be one of {", ".join(allowed)}.')
    return value


def run(name: str, start: Callable[[], Any],
        misconfigured: Callable[[str], Any] = lambda reason: None) -> None:
    """Run a node: `start` reads parameters, builds objects and connects callbacks; then wait.

    What `start` returns is kept alive, and its `close()`, if it has one, is called at shutdown.
    `misconfigured` is called with the reason when `start` raises ConfigurationError: there a node
    tells of it on topics of its own; what it returns is kept alive.
    """
    _end_on_signals()
    try:
        rospy.init_node(name, disable_signals=True)
    except rospy.ROSInitException:
        if rospy.is_shutdown():
            os._exit(0)  # ended before it had begun: rospy's server threads would stay for ever
        raise
    ending = threading.Event()
    rospy.on_shutdown(ending.set)
    _end_quietly(ending)
    watchdog.Watchdog()
    master_watch.watch_master()
    try:
        node = start()
    except ConfigurationError as error:
        rospy.logerr('%s cannot work: %s Mend it and restart the node.', rospy.get_name(), error)
        publish_diagnostics('none', {'configuration': _wrong(str(error))})
        node = misconfigured(str(error))
    else:
        if hasattr(node, 'close'):
            rospy.on_shutdown(node.close)
    _wait_for_end(ending)


def _wrong(reason: str) -> Task:
    """Says what is wrong for as long as the node waits to be restarted."""
    def tell(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        status.summary(DiagnosticStatus.ERROR, reason)
        return status
    return tell


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
