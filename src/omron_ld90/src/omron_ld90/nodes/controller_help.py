"""Reports sent commands that are not in the robot's help list.

The list forbids nothing; see `omron_arcl.HelpList`.
"""
from __future__ import annotations

import threading
from typing import List

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from omron_arcl import Command, HelpList
from omron_arcl.guard import is_unlisted

_MAXIMUM_NAMES = 20  # largest number of remembered commands


class HelpReport:
    """Compares the sent commands with the help list of the connected robot."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._help = HelpList({}, complete=False)
        self._unlisted: List[str] = []

    def listed(self, help_list: HelpList) -> None:
        """Takes the robot's list of commands."""
        with self._lock:
            self._help, self._unlisted = help_list, []

    def sent(self, command: Command) -> None:
        """Takes a sent command. Logs its name once if the robot does not list it."""
        with self._lock:
            name = command.name
            if (not is_unlisted(command, self._help) or name in self._unlisted
                    or len(self._unlisted) >= _MAXIMUM_NAMES):
                return
            self._unlisted.append(name)
        rospy.logwarn('The help list of the robot lacks the command %s; it was sent anyway.',
                      name)

    def diagnose(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fills in a status, as a task for diagnostic_updater."""
        with self._lock:
            help_list, unlisted = self._help, list(self._unlisted)
        if unlisted:
            status.summary(DiagnosticStatus.WARN, 'commands were sent that the robot does not '
                           f'list: {", ".join(unlisted)}')
        elif not help_list.descriptions:
            status.summary(DiagnosticStatus.OK, 'the robot has listed no commands')
        else:
            status.summary(DiagnosticStatus.OK, 'the robot lists all commands that were sent')
        status.add('commands listed', str(len(help_list)))
        status.add('end of the list seen', str(help_list.complete))
        return status
