"""The text of a map file: its bytes, its internal form, and its form for people.

The vendor's current tools write UTF-8. Older files and hand-made files contain bytes of
Windows-1252 (Latin-1 with more quotes). Internally, bytes that are not UTF-8 are kept as
surrogates, so that they are written back unchanged. For people they are converted to letters.
"""
from __future__ import annotations

import unicodedata

REPLACEMENT = '\ufffd'
LONGEST_PATH = 300  # characters of a path in a message


def decode(raw: bytes) -> str:
    """Returns `raw` as text; `encode` converts it back to the same bytes."""
    return raw.decode('utf-8', 'surrogateescape')


def encode(text: str) -> bytes:
    """Returns the bytes of `text`; raises UnicodeEncodeError for text that cannot be in a file."""
    return text.encode('utf-8', 'surrogateescape')


def printable(text: str) -> str:
    """Returns `text` for people: without control characters, and with a letter for each byte.

    Bytes that are not UTF-8 are read as Windows-1252. A byte that is not defined there, or a
    control character, becomes U+FFFD.
    """
    if text.isprintable():
        return text
    try:
        raw = encode(text)
    except UnicodeEncodeError:
        raw = text.encode('utf-8', 'replace')
    try:
        readable = raw.decode('utf-8')
    except UnicodeDecodeError:
        readable = raw.decode('cp1252', 'replace')
    return ''.join(REPLACEMENT if unicodedata.category(letter) == 'Cc' else letter
                   for letter in readable)


def printable_path(path: str) -> str:
    """Returns `path` for people: limited in length, and without control sequences of terminals."""
    shown = ''.join(letter if letter.isprintable() else letter.encode('unicode_escape').decode()
                    for letter in path)
    return shown if len(shown) <= LONGEST_PATH else f'{shown[:LONGEST_PATH]}...'
