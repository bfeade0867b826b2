#!/usr/bin/env python3
"""Mirrors one ROS master into another, for tests on machines without fkie multimaster.

master_mirror.py OWN_URI PEER_URI CROSSING_FILE

Registers the peer's publishers and subscribers of certain topics at this side's master, like fkie's
master_sync. CROSSING_FILE lists these topics. When the peer's nodes or the peer's master have
ended, the program withdraws the registrations. There is no discovery: each side gets the address
that all nodes of the other side use.
"""
from __future__ import annotations

import http.client
import re
import signal
import sys
import time
import xmlrpc.client
from typing import NamedTuple, Sequence, Set
from urllib.parse import urlsplit

import yaml

PERIOD = 0.5  # s between two queries of the peer
PATIENCE = 20.0  # s without an answer, after which the peer's nodes are withdrawn
TIMEOUT = 2.0   # s for one call
_FAILURES = (OSError, http.client.HTTPException, xmlrpc.client.Error)


class Registration(NamedTuple):
    """A node that publishes or subscribes, as registered at a master."""

    kind: str  # class name: Publisher or Subscriber
    topic: str
    type: str
    node: str
    api: str


class _Transport(xmlrpc.client.Transport):
    def make_connection(self, host: str) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT
        return connection


class Mirror:
    """Mirrors the peer's registrations; see the docstring of the module."""

    def __init__(self, own: str, peer: str, topics: Sequence[str]) -> None:
        self._own = xmlrpc.client.ServerProxy(own, transport=_Transport())
        self._peer = xmlrpc.client.ServerProxy(peer, transport=_Transport())
        self._address = urlsplit(peer).hostname
        self._wanted = re.compile('|'.join(
            re.escape(topic).replace(r'\*', '[^/]+') for topic in topics) + r'\Z')
        self._mirrored: Set[Registration] = set()
        self._heard = time.monotonic()

    def update(self) -> None:
        """Brings the registrations at this side's master up to date with those of the peer."""
        try:
            there = self._registrations()
            self._heard = time.monotonic()
        except _FAILURES:
            if time.monotonic() - self._heard < PATIENCE:
                return
            there = set()
        try:
            for gone in self._mirrored - there:
                self._withdraw(gone)
            for new in there - self._mirrored:
                self._register(new)
            # If this side's master was restarted, it has lost its registrations.
            self._mirrored = there & self._known()
        except _FAILURES:
            self._mirrored = set()

    def _registrations(self) -> Set[Registration]:
        """Returns the registrations of the peer's own nodes for the topics that cross."""
        _, _, (publishers, subscribers, _) = self._peer.getSystemState('/mirror')
        _, _, pairs = self._peer.getTopicTypes('/mirror')
        types, apis, found = dict(map(tuple, pairs)), {}, set()
        for kind, topics in (('Publisher', publishers), ('Subscriber', subscribers)):
            for topic, nodes in topics:
                if not self._wanted.match(topic):
                    continue
                for node in nodes:
                    if node not in apis:
                        _, _, apis[node] = self._peer.lookupNode('/mirror', node)
                    if urlsplit(apis[node]).hostname == self._address:
                        found.add(Registration(kind, topic, types.get(topic, '*'), node,
                                               apis[node]))
        return found

    def _known(self) -> Set[Registration]:
        _, _, (publishers, subscribers, _) = self._own.getSystemState('/mirror')
        known = {(kind, topic, node) for kind, topics in (('Publisher', publishers),
                                                          ('Subscriber', subscribers))
                 for topic, nodes in topics for node in nodes}
        return {one for one in self._registrations() if (one.kind, one.topic, one.node) in known}

    def _register(self, new: Registration) -> None:
        register = getattr(self._own, f'register{new.kind}')
        _, _, publishers = register(new.node, new.topic, new.type, new.api)
        if new.kind == 'Subscriber' and publishers:
            node = xmlrpc.client.ServerProxy(new.api, transport=_Transport())
            node.publisherUpdate('/mirror', new.topic, publishers)

    def _withdraw(self, gone: Registration) -> None:
        getattr(self._own, f'unregister{gone.kind}')(gone.node, gone.topic, gone.api)


def main() -> None:
    """Mirrors until the process is ended."""
    signal.signal(signal.SIGINT, lambda *_: sys.exit(0))
    own, peer, file = sys.argv[1:]
    with open(file, encoding='utf-8') as stream:
        topics = yaml.safe_load(stream)['sync_topics']
    mirror = Mirror(own, peer, topics)
    while True:
        mirror.update()
        time.sleep(PERIOD)


if __name__ == '__main__':
    main()
