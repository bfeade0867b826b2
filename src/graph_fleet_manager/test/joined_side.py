"""A stand-in for the other side of joined ROS masters: a master and master_discovery (XML-RPC)."""
from __future__ import annotations

import socket
import threading
import time
from typing import Any, Dict, List
from xmlrpc.client import ServerProxy
from xmlrpc.server import SimpleXMLRPCServer


class OtherSide:
    """Serves the master and master_discovery at an address; the attributes are the answers."""

    def __init__(self, address: str) -> None:
        self.address = address
        self.nodes: Dict[str, str] = {}
        self.definitions: Dict[str, str] = {}
        self.clock_offset = 0.0
        self.calls_back = True
        self.registered: List[str] = []
        self._servers: List[SimpleXMLRPCServer] = []
        self.master_port = self._serve(
            getPid=lambda _: (1, '', 4711), getSystemState=self._state, lookupNode=self._lookup,
            registerSubscriber=self._subscribe, registerPublisher=self._publish,
            unregisterSubscriber=self._unregister, unregisterPublisher=self._unregister)
        self.discovery_port = self._serve(
            getCurrentTime=lambda: ('http://x', time.time() + self.clock_offset),
            getTopicsMd5sum=lambda kinds: [(kind, self.definitions[kind]) for kind in kinds
                                           if kind in self.definitions])
        self.nodes['/rosout'] = f'http://{address}:{self.master_port}/'

    def _serve(self, **functions: Any) -> int:
        server = SimpleXMLRPCServer((self.address, 0), logRequests=False, allow_none=True)
        for name, function in functions.items():
            server.register_function(function, name)
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        self._servers.append(server)
        return server.server_address[1]

    def _state(self, _: str) -> Any:
        return 1, '', [[['/rosout', sorted(self.nodes)]], [], []]

    def _lookup(self, _: str, node: str) -> Any:
        return 1, '', self.nodes[node]

    def _subscribe(self, node: str, topic: str, kind: str, uri: str) -> Any:
        self.registered.append(uri)
        return 1, '', []

    def _publish(self, node: str, topic: str, kind: str, uri: str) -> Any:
        def tell() -> None:
            ServerProxy(self.registered[0]).publisherUpdate('/master', topic, [uri])
        if self.calls_back:
            threading.Thread(target=tell, daemon=True).start()
        return 1, '', self.registered

    def _unregister(self, node: str, topic: str, uri: str) -> Any:
        if uri in self.registered:
            self.registered.remove(uri)
        return 1, '', 1

    def close(self) -> None:
        """Ends both servers."""
        for server in self._servers:
            server.shutdown()
            server.server_close()


def unused_port(address: str) -> int:
    """Returns a port at which no program listens now."""
    with socket.socket() as probe:
        probe.bind((address, 0))
        return probe.getsockname()[1]
