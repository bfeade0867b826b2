"""Headers of every answer, and where requests may come from."""
from __future__ import annotations

import ssl
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
LOOPBACK = ('127.0.0.1', 'localhost', '::1')


class WrongCertificate(Exception):
    """The page cannot be served with it; the text is one sentence."""


def certificates_of(certificate: str, key: str) -> ssl.SSLContext:
    """What the page is served with by TLS, from PEM files; no key: the certificate's file has it.

    Raises WrongCertificate, also for a key with a password: no person is there to type it.
    """
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(certificate, key or None, password=lambda: '')
    except (OSError, ValueError) as error:  # ssl.SSLError is an OSError
        raise WrongCertificate(f'The certificate {certificate!r} with the key {key!r} cannot be '
                               f'used ({error}): name PEM files that belong together.') from None
    return context


def is_loopback(host: str) -> bool:
    """Is it an address that only this computer reaches?"""
    return host in LOOPBACK


@dataclass(frozen=True)
class Addresses:
    """By which names the page is reached; a request under another name is refused.

    So no other site can make a browser speak with the page under a name of its own. Without
    names, every one is taken: then only sessions protect the page.
    """

    names: FrozenSet[str]
    scheme: str

    @classmethod
    def of(cls, listen: str, names: Iterable[str], secure: bool) -> Addresses:
        """Of a page that listens there."""
        own = set(LOOPBACK) | set(names) | {listen}
        if listen in ('0.0.0.0', '::') and not names:
            own = set()
        return cls(frozenset(name.lower() for name in own), 'https' if secure else 'http')

    def allow_host(self, host: Optional[str]) -> bool:
        """Is this Host header one of the page?"""
        if not host:
            return False
        try:
            name = urlsplit(f'//{host}').hostname
        except ValueError:
            return False
        return name is not None and (not self.names or name.lower() in self.names)

    def allow_origin(self, origin: Optional[str], host: Optional[str]) -> bool:
        """Does a POST come from a page of this very address? One that says nothing does not."""
        return bool(host) and origin == f'{self.scheme}://{host}'
