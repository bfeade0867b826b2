"""The security headers of each answer, and the checks of a request's host and origin."""
from __future__ import annotations

from dataclasses import dataclass
from typing import FrozenSet, Iterable, Optional
from urllib.parse import urlsplit

HEADERS = {
    'Content-Security-Policy': (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"),
    'X-Content-Type-Options': 'nosniff',
    'X-Frame-Options': 'DENY',
    'Referrer-Policy': 'no-referrer',
    'Cross-Origin-Opener-Policy': 'same-origin',
    'Cross-Origin-Resource-Policy': 'same-origin',
    'Cache-Control': 'no-store',
}
TRANSPORT = {'Strict-Transport-Security': 'max-age=31536000'}
"""The further header of a page with TLS. A browser that has accepted the certificate then uses TLS
for each later request to this host name."""
LOOPBACK = ('127.0.0.1', 'localhost', '::1')


def is_loopback(host: str) -> bool:
    """Returns whether only this computer can reach the address."""
    return host in LOOPBACK


@dataclass(frozen=True)
class Addresses:
    """The host names of the page. A request with another host name is refused.

    So another web site cannot make a browser send requests to the page under its own name. If
    `names` is empty, each host name is accepted; then only sessions protect the page.
    """

    names: FrozenSet[str]
    scheme: str

    @classmethod
    def of(cls, listen: str, names: Iterable[str], secure: bool) -> Addresses:
        """Returns the addresses of a page that listens at `listen` and has these further names."""
        own = set(LOOPBACK) | set(names) | {listen}
        if listen in ('0.0.0.0', '::') and not names:
            own = set()
        return cls(frozenset(name.lower() for name in own), 'https' if secure else 'http')

    def allow_host(self, host: Optional[str]) -> bool:
        """Returns whether a Host header names this page."""
        if not host:
            return False
        try:
            name = urlsplit(f'//{host}').hostname
        except ValueError:
            return False
        return name is not None and (not self.names or name.lower() in self.names)

    def allow_origin(self, origin: Optional[str], host: Optional[str]) -> bool:
        """Returns whether the Origin of a POST is this page. A missing Origin is not allowed."""
        return bool(host) and origin == f'{self.scheme}://{host}'
