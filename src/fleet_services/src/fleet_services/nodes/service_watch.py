"""service_watch: tells systemd that the nodes of a unit have started and that no node hangs.

The watchdog of each node publishes in /diagnostics. When every node of the unit has had a good
report, this node sends READY=1 to systemd. Then it sends WATCHDOG=1 each second, as long as every
node had a good report within the last 15 s. Without WATCHDOG=1, systemd restarts the unit after the
unit's WatchdogSec.

Subscribes
    /diagnostics (diagnostic_msgs/DiagnosticArray)
Parameters
    ~nodes  string  required  names of the nodes, separated by blanks

Outside of a service (no NOTIFY_SOCKET) it only logs.
"""
from __future__ import annotations

import os
import socket
import time
from typing import FrozenSet

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus

from fleet_services.health import Health
from node_lifecycle import parameter, run
from node_lifecycle.periodic import Periodic

PERIOD = 1.0  # s
_ENDING = ': threads'  # suffix of the names of watchdog statuses


class ServiceWatch:
    """Listens to the watchdogs, and notifies systemd (sd_notify(3))."""

    def __init__(self) -> None:
        self._health = Health(parameter('~nodes', '', str).split())
        self._is_ready = False
        self._hung: FrozenSet[str] = frozenset()
        rospy.Subscriber('/diagnostics', DiagnosticArray, self._on_diagnostics, queue_size=100)
        Periodic('service watch', PERIOD, self._on_period)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.endswith(_ENDING):
                self._health.hear('/' + status.name[:-len(_ENDING)],
                                  status.level == DiagnosticStatus.OK, time.monotonic())

    def _on_period(self) -> None:
        hung = self._health.hung(time.monotonic())
        if hung - self._hung:
            rospy.logerr('No good report of the watchdog for 15 s: %s. systemd restarts this unit '
                         'unless one comes.', ', '.join(sorted(hung)))
        self._hung = hung
        if not self._is_ready and self._health.is_ready:
            self._is_ready = True
            rospy.loginfo('All %d nodes of this unit work.', len(self._health.nodes))
            notify('READY=1')
        if self._is_ready and not hung:
            notify('WATCHDOG=1')


def notify(state: str) -> None:
    """Sends one datagram to systemd, if this process belongs to a service."""
    address = os.environ.get('NOTIFY_SOCKET', '')
    if address:
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as systemd:
            systemd.connect('\0' + address[1:] if address.startswith('@') else address)
            systemd.send(state.encode())


def main() -> None:
    """Runs the node."""
    run('service_watch', ServiceWatch)
