"""Reports the state of a link: latched on `link_state`, in /diagnostics, and in the log.

Topics out:
  link_state (omron_ld90_msgs/LinkState, latched): one message per link, repeated every second to
      show that the node is alive
"""
from __future__ import annotations

import threading
import time
from typing import Callable, Dict, NamedTuple, Optional

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from node_lifecycle import ConfigurationError, number, parameter, warn
from node_lifecycle.periodic import Periodic
from omron_arcl import Link, LinkPhase, SessionLog, printable
from omron_arcl.connection import is_host
from omron_ld90_msgs.msg import LinkState

_STATES: Dict[LinkPhase, int] = {
    LinkPhase.DISCONNECTED: LinkState.DISCONNECTED,
    LinkPhase.CONNECTING: LinkState.CONNECTING,
    LinkPhase.LOGGING_IN: LinkState.LOGGING_IN,
    LinkPhase.CONNECTED: LinkState.CONNECTED,
    LinkPhase.WRONG_PASSWORD: LinkState.WRONG_PASSWORD,
}
_WORDS = {**{state: phase.value for phase, state in _STATES.items()},
          LinkState.MISCONFIGURED: 'misconfigured'}
PATIENCE = 15.0  # s after the start until a robot that was not reached is reported as a problem
SETTLED = 0.8    # s until a lost link is logged: at Ctrl-C, a simulator may end before the node
REPEATED = 1.0  # s between two messages about a link that has not changed
_LASTING = (LinkPhase.DISCONNECTED, LinkPhase.WRONG_PASSWORD, LinkPhase.CONNECTED)


def words_of(state: int) -> str:
    """Returns a LinkState's `state` in words."""
    return _WORDS.get(state, f'state {state}')


def robot_host() -> str:
    """Returns `~robot_ip`. Raises ConfigurationError if it is neither a name nor an address."""
    host = parameter('~robot_ip')
    if not is_host(host):
        raise ConfigurationError(f'Parameter {rospy.resolve_name("~robot_ip")} is '
                                 f'"{printable(host)}", which is neither an address nor a name.')
    return host


def session_log() -> Optional[SessionLog]:
    """Returns the session log in the file `~session_log`, with at most `~session_log_size` MB.

    None: `~session_log` is empty. Raises ConfigurationError.
    """
    path, size = parameter('~session_log', ''), number('~session_log_size', 50.0, 0.1)
    try:
        return SessionLog(path, round(size * 1e6)) if path else None
    except OSError as error:
        raise ConfigurationError(f'Parameter {rospy.resolve_name("~session_log")}: {path} cannot '
                                 f'be written: {error.strerror}.') from None


def misconfigured(link: str) -> Callable[[str], rospy.Publisher]:
    """Returns a function for `node_lifecycle.run`. The function publishes once on `link_state` why
    `link` cannot be set up.
    """
    def publish(reason: str) -> rospy.Publisher:
        publisher = _publisher()
        message = LinkState(link=link, state=LinkState.MISCONFIGURED, reason=reason)
        message.header.stamp = rospy.Time.now()
        publisher.publish(message)
        return publisher
    return publish


def _publisher() -> rospy.Publisher:
    return rospy.Publisher('link_state', LinkState, queue_size=5, latch=True, tcp_nodelay=True)


class _Lost(NamedTuple):
    """A link that is down, and the time (monotonic, s) at which this is logged."""

    link: Link
    due: float


class LinkReporter:
    """Reports the state of one link. Pass `report` as on_link; call `line` for every received line.

    The attributes are the data of one message and of one diagnosis.
    """

    def __init__(self, name: str, log: Optional[SessionLog] = None) -> None:
        self._name = name
        self._log = log
        self._publisher = _publisher()
        self._lock = threading.Lock()  # guards _message, so that no old message follows a new one
        self._message: Optional[LinkState] = None
        self._link: Optional[Link] = None
        self._last_reported: Optional[Link] = None
        self._since = rospy.Time.now()
        self._connections = 0
        self._began = time.monotonic()
        self._awaited: Optional[_Lost] = None
        self._last_line: Optional[float] = None
        self._lines = 0
        self._counted = (time.monotonic(), 0)
        Periodic('link state', REPEATED, self._repeat)

    def line(self) -> None:
        """Counts a received line."""
        self._last_line = time.monotonic()
        self._lines += 1

    def _repeat(self) -> None:
        with self._lock:
            if self._message is not None:
                self._publisher.publish(self._message)
        awaited = self._awaited
        if awaited is not None and time.monotonic() >= awaited.due:
            self._log_change(awaited.link)

    @property
    def _is_beginning(self) -> bool:
        """Whether the robot was never reached, but this node has just started (`PATIENCE`)."""
        return not self._connections and time.monotonic() - self._began < PATIENCE

    def report(self, link: Link) -> None:
        """Publishes a change of the link, and logs it at once or later."""
        if self._link is None or link.phase is not self._link.phase:
            self._since = rospy.Time.now()
        self._link = link
        message = LinkState(link=self._name, state=_STATES[link.phase], address=link.peer,
                            reason=link.reason)
        message.header.stamp = self._since
        with self._lock:
            self._message = message
            self._publisher.publish(message)
        if link.connected:
            self._connections += 1
        awaited = self._awaited
        if link.phase in _LASTING and (awaited or link != self._last_reported):
            if link.phase is LinkPhase.DISCONNECTED:
                if awaited is None:
                    due = self._began + PATIENCE if self._is_beginning else (
                        time.monotonic() + SETTLED)
                    self._awaited = _Lost(link, due)
                return
            if awaited is not None and self._connections > 1:
                self._log_change(awaited.link)
            self._log_change(link)

    def _log_change(self, link: Link) -> None:
        self._last_reported, self._awaited = link, None
        if link.connected:
            rospy.loginfo('Link "%s" to %s is up.', self._name, link.peer)
            if link.reason:
                warn('link', f'Link "{self._name}" to {link.peer}: {link.reason}.')
        elif not rospy.core.is_shutdown_requested():  # is_shutdown() is still False at the end
            warn('link', f'Link "{self._name}" to {link.peer} is down: {link.reason}.')

    def diagnose(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        """Fills in a status, as a task for diagnostic_updater."""
        link = self._link
        if link is None:
            status.summary(DiagnosticStatus.WARN, 'starting')
            return status
        if link.connected:
            status.summary(DiagnosticStatus.WARN if link.reason else DiagnosticStatus.OK,
                           link.reason or 'connected')
        elif self._is_beginning and link.phase is not LinkPhase.WRONG_PASSWORD:
            status.summary(DiagnosticStatus.WARN, f'connecting: {link.reason}')
        else:
            status.summary(DiagnosticStatus.ERROR, f'{link.phase.value}: {link.reason}')
        now = time.monotonic()
        then, count = self._counted
        self._counted = (now, self._lines)
        status.add('peer', link.peer)
        status.add('state', link.phase.value)
        status.add('since', f'{self._since.to_sec():.3f}')
        status.add('connections made', str(self._connections))
        status.add('lines per second', f'{(self._lines - count) / max(now - then, 1e-3):.1f}')
        status.add('age of last line [s]',
                   'none yet' if self._last_line is None else f'{now - self._last_line:.2f}')
        if self._log:
            if self._log.failure:
                status.mergeSummary(DiagnosticStatus.WARN, f'session log: {self._log.failure}')
            status.add('session log', self._log.failure or self._log.path)
        return status
