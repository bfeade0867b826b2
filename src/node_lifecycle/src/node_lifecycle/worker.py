"""A thread without which a node cannot work.

If only this thread ended, the node would keep its topics and do nothing, but seem to work. So an
error in the thread ends the whole process, and roslaunch restarts the node.
"""
from __future__ import annotations

import os
import threading
import traceback
from typing import Callable

import rospy


def start_worker(name: str, work: Callable[[], None],
                 end_process: Callable[[int], object] = os._exit) -> threading.Thread:
    """Runs `work` in a daemon thread; an exception of `work` ends the process."""
    def run() -> None:
        try:
            work()
        except Exception as error:
            if _is_end_of_node(error):
                return
            rospy.logfatal('%s ends because of an internal error in its thread "%s":\n%s',
                           rospy.get_name(), name, traceback.format_exc())
            end_process(1)

    thread = threading.Thread(target=run, name=name, daemon=True)
    thread.start()
    return thread


def _is_end_of_node(error: Exception) -> bool:
    """Returns whether the end of the node caused the error: topics close before is_shutdown() is
    true.
    """
    return rospy.is_shutdown() or (isinstance(error, rospy.ROSException)
                                   and 'closed topic' in str(error))
