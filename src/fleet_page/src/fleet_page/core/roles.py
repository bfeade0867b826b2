"""Permissions: a file gives each token a role; a login with a token opens a session (a cookie)."""
from __future__ import annotations

import hashlib
import hmac
import os
import re
import secrets
import stat
from dataclasses import dataclass
from enum import IntEnum
from shlex import quote
from typing import Dict, List, Optional, Tuple

SHORTEST_TOKEN = 16       # characters
SESSION_TIME = 12 * 3600  # s: a session without a request for this time is over
MOST_SESSIONS = 1000
_NAME = re.compile(r'[A-Za-z0-9_.-]{1,40}')


class UserRole(IntEnum):
    """A role. A higher role permits everything that a lower role permits."""

    SEE = 1
    OPERATE = 2
    ADMIN = 3


@dataclass(frozen=True)
class Person:
    """A user of the page. The name appears in the records and in `requested_by`."""

    name: str
    role: UserRole


LOCAL = Person('local', UserRole.ADMIN)
"""The person of all requests if there is no token file: then only this computer reaches the page.
"""


class TokenFileError(Exception):
    """The token file cannot be used. The text says why and what to do, without any token."""


class Tokens:
    """The persons, by the digests of their tokens."""

    def __init__(self, persons: Dict[bytes, Person]) -> None:
        self._persons = persons

    def person(self, token: str) -> Optional[Person]:
        """Returns the owner of a token, or None. The comparison takes the same time for any token.
        """
        return self.owner(digest_of(token))

    def owner(self, digest: bytes) -> Optional[Person]:
        """Returns the owner of the token with this digest, or None."""
        found = None
        for known, person in self._persons.items():
            if hmac.compare_digest(known, digest):
                found = person
        return found


def load_tokens(path: str) -> Tokens:
    """Returns the tokens in a file of lines `ROLE NAME TOKEN`; raises TokenFileError."""
    try:
        with open(path, encoding='utf-8') as stream:
            status = os.fstat(stream.fileno())
            lines = stream.read().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise TokenFileError(f'The token file {path} cannot be read ({error}).') from None
    if stat.S_IMODE(status.st_mode) & 0o077:
        raise TokenFileError(f'Others may read the token file {path}: chmod 600 {quote(path)}')
    persons: Dict[bytes, Person] = {}
    for number, line in enumerate(lines, 1):
        if line.strip() and not line.lstrip().startswith('#'):
            digest, person = _person(line.split(), f'{path}, line {number}')
            if digest in persons:
                raise TokenFileError(f'{path}, line {number}: the token occurs twice.')
            persons[digest] = person
    if not persons:
        raise TokenFileError(f'The token file {path} has no token: write lines ROLE NAME TOKEN.')
    return Tokens(persons)


class TokenFile:
    """The tokens in a file that may change while the page runs. The first reading may raise
    TokenFileError.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        self._seen = _identity(path)
        self.tokens = load_tokens(path)

    def refresh(self) -> bool:
        """Reads the file if it has changed. Returns whether the tokens may have changed.

        Raises TokenFileError once for each change that makes the file unusable. The tokens then
        stay as they were: a mistake in the file must not deprive the people on the floor of STOP.
        """
        seen = _identity(self._path)
        if seen == self._seen:
            return False
        self._seen = seen
        self.tokens = load_tokens(self._path)
        return True


def _identity(path: str) -> Optional[Tuple[int, ...]]:
    try:
        status = os.stat(path)
    except OSError:
        return None
    return status.st_ino, status.st_dev, status.st_size, status.st_mtime_ns, status.st_mode


def _person(words: List[str], where: str) -> Tuple[bytes, Person]:
    if len(words) != 3:
        raise TokenFileError(f'{where}: the line must be ROLE NAME TOKEN.')
    role, name, token = words
    if role.upper() not in UserRole.__members__:
        raise TokenFileError(f'{where}: the role must be see, operate or admin.')
    if not _NAME.fullmatch(name):
        raise TokenFileError(f'{where}: the name must be of letters, digits, _ . and -.')
    if len(token) < SHORTEST_TOKEN:
        raise TokenFileError(f'{where}: the token must have {SHORTEST_TOKEN} characters or more: '
                             'take one of `openssl rand -hex 16`.')
    return digest_of(token), Person(name, UserRole[role.upper()])


class Sessions:
    """Open sessions. For each session, only the digests of its id and of its token are kept."""

    def __init__(self) -> None:
        self._sessions: Dict[bytes, Tuple[bytes, float]] = {}

    def open(self, token: str, now: float) -> str:
        """Opens a session with a valid token. Returns the session's id, which is the cookie."""
        if len(self._sessions) >= MOST_SESSIONS:
            oldest = min(self._sessions, key=lambda key: self._sessions[key][1])
            del self._sessions[oldest]
        session = secrets.token_urlsafe(32)
        self._sessions[digest_of(session)] = (digest_of(token), now)
        return session

    def person(self, session: str, tokens: Tokens, now: float) -> Optional[Person]:
        """Returns the owner of a session according to the present tokens.

        None: the session does not exist, is over, or its token is not valid any more.
        """
        key = digest_of(session)
        known = self._sessions.get(key)
        if known is None:
            return None
        token, used = known
        person = tokens.owner(token)
        if person is None or now - used > SESSION_TIME:
            del self._sessions[key]
            return None
        self._sessions[key] = (token, now)
        return person

    def close(self, session: str) -> None:
        """Ends a session."""
        self._sessions.pop(digest_of(session), None)


def digest_of(text: str) -> bytes:
    """Returns the digest of a secret. Secrets themselves are not kept."""
    return hashlib.sha256(text.encode('utf-8', 'surrogatepass')).digest()
