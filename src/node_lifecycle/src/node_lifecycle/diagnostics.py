"""A node's part of /diagnostics: the statuses of its tasks, once a second until it ends."""
from __future__ import annotations

from typing import Any, Callable, Mapping

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper, Updater

from node_lifecycle.log_throttle import warn
from node_lifecycle.periodic import Periodic

PERIOD = 1.0  # s
Task = Callable[[DiagnosticStatusWrapper], Any]  # fills the status in


def publish_diagnostics(hardware_id: str, tasks: Mapping[str, Task]) -> None:
    """Publishes the tasks' statuses, each as `<node>: <its name>`; a separate thread calls them.

    `hardware_id`: what the statuses are about, the robot's address or name, else `none`.
    """
    updater = Updater()
    updater.setHardwareID(hardware_id)
    for name, task in tasks.items():
        updater.add(name, guarded(task))
    Periodic('diagnostics', PERIOD, updater.force_update)


def guarded(task: Task) -> Callable[[DiagnosticStatusWrapper], DiagnosticStatusWrapper]:
    """Returns the task, with its failures reported as a status; an exception would end all
    diagnostics.

    Text that is not valid Unicode, such as some names in files, is escaped for the same reason. The
    log gets a line when the task begins to fail, when its failure changes, and when it works again.
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
