"""XML-RPC calls to another ROS master, and to fkie's master_discovery beside it.

Nothing here is a ROS node. Each call has a timeout. The form of each answer is checked, because it
comes from a program on another computer.
"""
from __future__ import annotations

import http.client
import math
import time
import xml.parsers.expat
import xmlrpc.client
from typing import Any, Callable, Dict, List, NamedTuple, Sequence

MASTER_PORT = 11311     # TCP port of a ROS master
DISCOVERY_PORT = 11621  # TCP port of master_discovery, as join_masters.launch sets it
TIMEOUT = 2.0           # s for one call
_CALLER = '/graph_fleet_manager'
_MOST = 10000           # the most entries of an answer that are used
_FAILURES = (OSError, http.client.HTTPException, xmlrpc.client.Error,
             xml.parsers.expat.ExpatError, ValueError, TypeError, KeyError)


class NoAnswer(Exception):
    """No answer came, or the answer was invalid. The text is a clause that describes the failure.
    """


class ClockOffset(NamedTuple):
    """How far (s) another computer's clock is ahead of this clock, and the error (s) of this value.
    """

    offset: float
    uncertainty: float


class _Transport(xmlrpc.client.Transport):
    """A transport with a timeout for each call."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        """Makes a connection with the timeout."""
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT
        return connection


def proxy(uri: str) -> Any:
    """Returns a proxy for the XML-RPC server at `uri`, with a timeout."""
    return xmlrpc.client.ServerProxy(uri, transport=_Transport())


def _ask(question: Callable[[], Any]) -> Any:
    try:
        return question()
    except _FAILURES as failure:
        reason = failure.strerror if isinstance(failure, OSError) else None
        raise NoAnswer(reason or str(failure) or type(failure).__name__) from None


class MasterApi:
    """The API of a ROS master."""

    def __init__(self, uri: str) -> None:
        self.uri = uri
        self.api = proxy(uri)

    def nodes(self) -> Dict[str, str]:
        """Returns the URI of the API of each registered node, by its name; raises NoAnswer."""
        state = self.value(lambda: self.api.getSystemState(_CALLER))
        names = _ask(lambda: sorted({str(node) for kind in state for _, nodes in kind
                                     for node in nodes})[:_MOST])
        return {name: self.node_uri(name) for name in names}

    def node_uri(self, name: str) -> str:
        """Returns the URI of a node's API; raises NoAnswer."""
        return str(self.value(lambda: self.api.lookupNode(_CALLER, name)))

    def service_uri(self, name: str) -> str:
        """Returns the address of a service (rosrpc://); raises NoAnswer."""
        return str(self.value(lambda: self.api.lookupService(_CALLER, name)))

    def topic_types(self) -> Dict[str, str]:
        """Returns the message type of every topic; raises NoAnswer."""
        pairs = self.value(lambda: self.api.getTopicTypes(_CALLER))
        return _ask(lambda: {str(topic): str(kind) for topic, kind in pairs[:_MOST]})

    def pid(self) -> int:
        """Returns the process id of the master, which a restart changes; raises NoAnswer."""
        return int(self.value(lambda: self.api.getPid(_CALLER)))

    @staticmethod
    def value(question: Callable[[], Any]) -> Any:
        """Returns the result of a call of the API. Raises NoAnswer, also if the master refuses the
        call.
        """
        code, said, value = _ask(lambda: _triple(question()))
        if code != 1:
            raise NoAnswer(said)
        return value


class Discovery:
    """fkie's master_discovery on another computer."""

    def __init__(self, address: str, port: int = DISCOVERY_PORT) -> None:
        self._api = proxy(f'http://{address}:{port}')

    def clock(self) -> ClockOffset:
        """Compares the other computer's clock with this computer's clock; raises NoAnswer."""
        before = time.time()
        moment = _ask(lambda: float(self._api.getCurrentTime()[1]))
        after = time.time()
        if not math.isfinite(moment):
            raise NoAnswer('its time is not a number')
        return ClockOffset(moment - (before + after) / 2.0, (after - before) / 2.0)

    def definitions(self, types: Sequence[str]) -> Dict[str, str]:
        """Returns the MD5 sums of these message types, by type, as far as the other side has the
        types.

        Raises NoAnswer.
        """
        pairs: List[Any] = _ask(lambda: list(self._api.getTopicsMd5sum(list(types)))[:_MOST])
        return _ask(lambda: {str(kind): str(md5) for kind, md5 in pairs if kind in types})


def _triple(answer: Any) -> Any:
    code, said, value = answer
    return int(code), str(said), value
