"""A node's part in /diagnostics: what its tasks say of it, once a second until it ends."""
from __future__ import annotations

from typing import Callable, Mapping

import rospy
from diagnostic_updater import DiagnosticStatusWrapper, Updater

PERIOD = rospy.Duration(1.0)
Task = Callable[[DiagnosticStatusWrapper], DiagnosticStatusWrapper]


def publish_diagnostics(hardware_id: str, tasks: Mapping[str, Task]) -> None:
    """Publishes the tasks' statuses, each as `<node>: <its name>`; a thread of its own asks them.

    `hardware_id` says what the statuses are about: the robot's address or name, else `none`.
    """
    updater = Updater()
    updater.setHardwareID(hardware_id)
    for name, task in tasks.items():
        updater.add(name, task)
    timer = rospy.Timer(PERIOD, lambda _: updater.force_update())
    rospy.on_shutdown(timer.shutdown)
