"""A thread without which a node is of no use.

Were it to end on a defect, the node would keep its topics and do nothing: to others it would look
alive. So the whole process ends, and roslaunch starts it anew.
"""
from __future__ import annotations

import os
import threading
import traceback
from typing import Callable

import rospy


def start_worker(name: str, work: Callable[[], None],
                 end_process: Callable[[int], object] = os._exit) -> threading.Thread:
    """Begins `work` in a daemon thread; an exception that it raises ends the process."""
    def run() -> None:
        try:
            work()
        except Exception as error:
            if _is_end_of_node(error):
                return
            rospy.logfatal('%s ends on a defect of its own, in its thread "%s":\n%s',
                           rospy.get_name(), name, traceback.format_exc())
            end_process(1)

    thread = threading.Thread(target=run, name=name, daemon=True)
    thread.start()
    return thread


def _is_end_of_node(error: Exception) -> bool:
    """Topics close before rospy says that it is shut down."""
    return rospy.is_shutdown() or (isinstance(error, rospy.ROSException)
                                   and 'closed topic' in str(error))
