"""A node's part of /diagnostics: the statuses of its tasks, once a second until the node ends."""
from __future__ import annotations

from typing import Any, Callable, Mapping

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper, Updater

from node_lifecycle.log_throttle import warn
from node_lifecycle.periodic import Periodic

PERIOD = 1.0  # s
Task = Callable[[DiagnosticStatusWrapper], Any]  # fills in the status


def publish_diagnostics(hardware_id: str, tasks: Mapping[str, Task]) -> None:
    """Publishes the status of each task as `<node>: <name>`; a separate thread calls the tasks.

    hardware_id -- the robot's address or name, if the statuses are about a robot; otherwise `none`
    """
    updater = Updater()
    updater.setHardwareID(hardware_id)
    for name, task in tasks.items():
        updater.add(name, guarded(task))
    Periodic('diagnostics', PERIOD, updater.force_update)


def guarded(task: Task) -> Callable[[DiagnosticStatusWrapper], DiagnosticStatusWrapper]:
    """Returns the task with one change: if the task fails, its status reports the failure. Without
    this change, an exception would end all diagnostics.

    Text that is not valid Unicode, such as some file names, is escaped for the same reason. The log
    gets a line when the task begins to fail, when the failure changes, and when the task works
    again.
    """
    failed = ''

    def ask(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        nonlocal failed
        before, failed = failed, ''
        try:
            task(status)
        except Exception as error:
            failed = repr(error)
            status.summary(DiagnosticStatus.ERROR, f'this diagnosis failed: {failed}')
        if failed != before:
            warn('diagnostics', f'A part of the diagnostics failed: {failed}' if failed else
                 'The part of the diagnostics that had failed works again.')
        status.message = _encodable(status.message)
        for value in status.values:
            value.value = _encodable(value.value)
        return status
    return ask


def _encodable(text: str) -> str:
    return text.encode('utf-8', 'backslashreplace').decode('utf-8')
