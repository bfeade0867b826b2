"""Text of a map file: its bytes, what is worked with, and what people are shown.

Files are UTF-8 as far as the vendor's current tools wrote them. Older and hand-made ones hold bytes
of Windows-1252 (Latin-1 with more quotes). While a map is worked with, bytes that are not UTF-8 are
kept as surrogates, so that they are written back as they were. People are shown letters.
"""
from __future__ import annotations

import unicodedata

REPLACEMENT = '\ufffd'
LONGEST_PATH = 300  # characters of a path in a message


def decode(raw: bytes) -> str:
    """`raw` as text from which `encode` makes the same bytes."""
    return raw.decode('utf-8', 'surrogateescape')


def encode(text: str) -> bytes:
    """The bytes of `text`; raises UnicodeEncodeError for what no file holds."""
    return text.encode('utf-8', 'surrogateescape')


def printable(text: str) -> str:
    """`text` as people read it: without control characters, and with letters for all bytes.

    The bytes are read as Windows-1252 where they are not UTF-8; a byte without meaning there, and
    a control character, becomes U+FFFD.
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
    """`path` for people: of bounded length, and without what a terminal would take as an order."""
    shown = ''.join(letter if letter.isprintable() else letter.encode('unicode_escape').decode()
                    for letter in path)
    return shown if len(shown) <= LONGEST_PATH else f'{shown[:LONGEST_PATH]}...'
