"""Makes the XML-RPC servers of rosgraph (ROS master, nodes of rospy) refuse web browsers.

It is separate from `node_lifecycle` and does not import rospy, because the ROS master needs neither
of the two.
"""
from __future__ import annotations

import logging
import time
from http import HTTPStatus

import rosgraph.xmlrpc
from rosgraph.xmlrpc import SilenceableXMLRPCRequestHandler

from browser_guard import OwnHosts, reason_to_refuse

_LOG_PERIOD = 10.0  # s; a browser can send thousands of requests per second
_log = logging.getLogger('xmlrpc')


def guard_servers() -> None:
    """Guards all XML-RPC servers that this process starts from now on."""
    rosgraph.xmlrpc.SilenceableXMLRPCRequestHandler = GuardedRequestHandler


class GuardedRequestHandler(SilenceableXMLRPCRequestHandler):
    """Refuses a request before its body is read, and ends the connection."""

    hosts = OwnHosts()
    _next_log = 0.0

    def parse_request(self) -> bool:
        """Reads the request line and the headers. Returns False if the request was refused."""
        if not super().parse_request():
            return False
        reason = reason_to_refuse(self.command, self.headers.items(), self.hosts)
        if reason is None:
            return True
        self._record(reason)
        self.close_connection = True
        self.send_error(HTTPStatus.FORBIDDEN, reason)
        return False

    def _record(self, reason: str) -> None:
        now = time.monotonic()
        if now >= GuardedRequestHandler._next_log:
            GuardedRequestHandler._next_log = now + _LOG_PERIOD
            _log.warning('An XML-RPC request of %s for the host %.100r is refused: %s.',
                         self.client_address[0], self.headers.get('Host'), reason)
