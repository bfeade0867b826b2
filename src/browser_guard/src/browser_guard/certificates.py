"""The certificate by which a server on the network proves its name: PEM files, for TLS."""
from __future__ import annotations

import os
import ssl
from shlex import quote


class WrongCertificate(Exception):
    """The certificate cannot be used. The text is one sentence."""


def certificates_of(certificate: str, key: str) -> ssl.SSLContext:
    """Returns the TLS context of a server, from PEM files.

    If `key` is empty, the key is in the certificate's file.

    Raises WrongCertificate, also for two kinds of keys: a key with a password, which no person can
    enter, and a key that every user of the computer may read.
    """
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(certificate, key or None, password=lambda: '')
    except (OSError, ValueError) as error:  # ssl.SSLError is an OSError
        raise WrongCertificate(f'The certificate {certificate!r} with the key {key!r} cannot be '
                               f'used ({error}): name PEM files that belong together.') from None
    _check_private(key or certificate)
    return context


def _check_private(path: str) -> None:
    if os.stat(path).st_mode & 0o007:
        raise WrongCertificate(f'Others may read the key in {path}: chmod 600 {quote(path)}, '
                               'or chmod 640 if a group must read it.')
