"""peer_watch: reports in /diagnostics the state of each other ROS master of a multimaster system.

It checks whether the other side answers, whether the clocks agree, and whether both sides have the
same message definitions. Without these checks the only sign of such a fault is a topic that is
listed but carries no messages. The node runs beside master_discovery
(docs/how-to/multimaster.md) and moves nothing.

Publishes
    /diagnostics: one status for each peer, `peer_watch: <address>`
Parameters
    ~peers           list of strings  addresses of the computers of the other masters
    ~discovery_port  int              11621, port of master_discovery on all of them
"""
from __future__ import annotations

import threading
import time
from typing import List, Optional

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from fleet_core.files.robot_computers import is_address
from graph_fleet_manager.messages.definitions import own_definitions
from graph_fleet_manager.multimaster.findings import (
    Checked,
    Grade,
    clock_finding,
    definitions_finding,
)
from graph_fleet_manager.multimaster.peer_master import (
    DISCOVERY_PORT,
    Discovery,
    NoAnswer,
)
from node_lifecycle import ConfigurationError, parameter, publish_diagnostics, run

PERIOD = 2.0  # s between two checks of a peer
LEVELS = {Grade.OK: DiagnosticStatus.OK, Grade.WARN: DiagnosticStatus.WARN,
          Grade.WRONG: DiagnosticStatus.ERROR}


class WatchedPeer:
    """A peer with a thread of its own: the check of a missing peer blocks until a timeout."""

    def __init__(self, address: str, port: int) -> None:
        self.address = address
        self._discovery = Discovery(address, port)
        self._own = own_definitions()
        self._findings: List[Checked] = []
        self._seen: Optional[float] = None
        self._lock = threading.Lock()
        threading.Thread(target=self._run, name=f'peer {address}', daemon=True).start()

    def _run(self) -> None:
        while not rospy.is_shutdown():
            findings = self._check()
            with self._lock:
                self._findings = findings
            time.sleep(PERIOD)

    def _check(self) -> List[Checked]:
        try:
            clock = self._discovery.clock()
            theirs = self._discovery.definitions(sorted(self._own))
        except NoAnswer as silence:
            since = '' if self._seen is None else (
                f' for {time.monotonic() - self._seen:.0f} s')
            return [Checked('link', Grade.WRONG, f'it does not answer{since} ({silence})',
                            f'run scripts/check_network.sh {self.address} to find out why')]
        self._seen = time.monotonic()
        return [definitions_finding(self._own, theirs), clock_finding(*clock)]

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Fills in the status for /diagnostics: the last findings about this peer."""
        with self._lock:
            findings = self._findings
        if not findings:
            status.summary(DiagnosticStatus.WARN, 'it was not checked yet')
            return
        worst = max(findings, key=lambda finding: finding.level)
        status.summary(LEVELS[worst.level], 'joined' if worst.level is Grade.OK else str(worst))
        for finding in findings:
            status.add(finding.subject, str(finding))


def _start() -> object:
    addresses = parameter('~peers', kind=list)
    if not addresses or not all(is_address(str(address)) for address in addresses):
        raise ConfigurationError(f'Parameter {rospy.resolve_name("~peers")} is {addresses!r}, but '
                                 'must be a list of addresses of computers.')
    port = parameter('~discovery_port', DISCOVERY_PORT, int)
    peers = [WatchedPeer(str(address), port) for address in addresses]
    publish_diagnostics('none', {peer.address: peer.report for peer in peers})
    return peers


def main() -> None:
    """Runs the node."""
    run('peer_watch', _start)
