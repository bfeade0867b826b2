"""The limits on connections before a login: who may stay, and who must give way to a newcomer.

A connection counts here while it waits for a request, or is served without a login. While it
carries out a request of a known person it does not count, and cannot be displaced.

A newcomer is let in although there is no room: the oldest connection of the address that has the
most gives way. So nobody can take all places and keep them, and an address with few connections
loses none as long as another has more.
"""
from __future__ import annotations

import ipaddress
from collections import OrderedDict
from dataclasses import dataclass
from typing import Dict, Hashable, Optional

from fleet_page.core.rate_limits import RateLimit

MOST_OF_ADDRESS = 32
MOST = 300
EACH_SECOND = 50.0  # newcomers per second that displace a connection of their own address


@dataclass(frozen=True)
class Arrival:
    """The decision about a newcomer: whether it may stay, and who must give way to it."""

    admitted: bool
    displaced: Optional[Hashable] = None


class Admissions:
    """The connections that count, by their addresses."""

    def __init__(self) -> None:
        self._addresses: Dict[Hashable, str] = {}
        self._of: Dict[str, OrderedDict[Hashable, None]] = {}
        self._changes = RateLimit(MOST_OF_ADDRESS, EACH_SECOND)

    def __len__(self) -> int:
        return len(self._addresses)

    def of_address(self, address: str) -> int:
        """The number of connections of an address that count."""
        return len(self._of.get(address, ()))

    def arrive(self, key: Hashable, address: str, now: float) -> Arrival:
        """Decides about a new connection.

        An address that changes its connections quickly is refused newcomers, because that is
        cheaper than to end a connection for each.
        """
        crowded = None
        if self.of_address(address) >= MOST_OF_ADDRESS:
            crowded = address
        elif len(self) >= MOST:
            crowded = max(self._of, key=lambda other: len(self._of[other]))
        if crowded == address and not self._changes.allows(address, now):
            return Arrival(False)
        displaced = None
        if crowded is not None:
            displaced = next(iter(self._of[crowded]))
            self.leave(displaced)
        self.count(key, address)
        return Arrival(True, displaced)

    def count(self, key: Hashable, address: str) -> None:
        """Counts a connection from now on, as the newest."""
        self._addresses[key] = address
        self._of.setdefault(address, OrderedDict())[key] = None

    def leave(self, key: Hashable) -> None:
        """No longer counts a connection."""
        address = self._addresses.pop(key, None)
        if address is not None:
            del self._of[address][key]
            if not self._of[address]:
                del self._of[address]


def place_of(address: str) -> str:
    """The address under which connections are counted: of IPv6 the network of one subscriber."""
    try:
        found = ipaddress.ip_address(address.partition('%')[0])
    except ValueError:
        return address
    if isinstance(found, ipaddress.IPv4Address):
        return str(found)
    if found.ipv4_mapped is not None:
        return str(found.ipv4_mapped)
    return str(ipaddress.ip_network((int(found), 64), strict=False))
