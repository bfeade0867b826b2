"""The limits on connections before a login: which connections are let in, and which are ended.

A connection counts while it waits for a request, or is served without a login. While it serves a
known person, it does not count and is not ended.

If there is no room for a new connection, the oldest connection of the address with the largest
number of connections is ended. So no client can take all places and keep them, and an address with
few connections loses none while another address has more. If half requests displace other
connections faster than the limit, a new connection is let in only when its request is complete,
because it costs least to refuse half a request.
"""
from __future__ import annotations

import ipaddress
from collections import OrderedDict
from functools import lru_cache
from typing import Dict, Hashable, Optional

from fleet_page.core.rate_limits import RateLimit

MOST_OF_ADDRESS = 96
MOST = 512
EACH_SECOND = 2000.0  # half requests per s that may displace connections, per address and in all


class Admissions:
    """The connections that count, by their addresses."""

    def __init__(self) -> None:
        self._addresses: Dict[Hashable, str] = {}
        self._of: Dict[str, OrderedDict[Hashable, None]] = {}
        self._by_size: Dict[int, OrderedDict[str, None]] = {}  # addresses, by number of connections
        self._largest = 0
        self._halves = RateLimit(EACH_SECOND, EACH_SECOND)

    def __len__(self) -> int:
        return len(self._addresses)

    def of_address(self, address: str) -> int:
        """Returns the number of connections of an address that count."""
        return len(self._of.get(address, ()))

    def must_bring_request(self, address: str, now: float) -> bool:
        """Returns whether a new connection of an address is let in only with a whole request."""
        if self.of_address(address) >= MOST_OF_ADDRESS:
            return not self._halves.allows(address, now)
        if len(self) >= MOST and self.of_address(address) >= self._largest - 1:
            return not self._halves.allows(None, now)
        return False

    def arrive(self, key: Hashable, address: str) -> Optional[Hashable]:
        """Counts a new connection. Returns the connection that must end to make room, or None."""
        displaced = None
        if self.of_address(address) >= MOST_OF_ADDRESS:
            displaced = next(iter(self._of[address]))
        elif len(self) >= MOST:
            displaced = next(iter(self._of[next(iter(self._by_size[self._largest]))]))
        if displaced is not None:
            self.leave(displaced)
        self.count(key, address)
        return displaced

    def count(self, key: Hashable, address: str) -> None:
        """Counts a connection as the newest of its address."""
        self.leave(key)
        self._addresses[key] = address
        connections = self._of.setdefault(address, OrderedDict())
        connections[key] = None
        self._resized(address, len(connections) - 1, len(connections))

    def leave(self, key: Hashable) -> None:
        """Stops counting a connection."""
        address = self._addresses.pop(key, None)
        if address is None:
            return
        connections = self._of[address]
        del connections[key]
        self._resized(address, len(connections) + 1, len(connections))
        if not connections:
            del self._of[address]

    def _resized(self, address: str, before: int, now: int) -> None:
        if before:
            del self._by_size[before][address]
        if now:
            self._by_size.setdefault(now, OrderedDict())[address] = None
        self._largest = max(self._largest, now)
        while self._largest and not self._by_size.get(self._largest):
            self._largest -= 1


@lru_cache(maxsize=4096)
def place_of(address: str) -> str:
    """Returns the address by which a connection is counted; for IPv6, a subscriber's network."""
    try:
        found = ipaddress.ip_address(address.partition('%')[0])
    except ValueError:
        return address
    if isinstance(found, ipaddress.IPv4Address):
        return str(found)
    if found.ipv4_mapped is not None:
        return str(found.ipv4_mapped)
    return str(ipaddress.ip_network((int(found), 64), strict=False))
