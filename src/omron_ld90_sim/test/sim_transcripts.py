"""Compares the lines of a session with the expected lines."""
from __future__ import annotations

import re
from typing import List, Sequence


def agree(wanted: str, line: str) -> bool:
    """Returns whether a line equals `wanted`, or matches it if `wanted` is `/.../`."""
    if wanted.startswith('/'):
        return re.fullmatch(wanted[1:-1], line) is not None
    return wanted == line


def check(wanted: Sequence[str], lines: List[str]) -> None:
    """Asserts that every line is as expected, and that there are no others."""
    for number, (expected, line) in enumerate(zip(wanted, lines)):
        assert agree(expected, line), f'line {number}: expected {expected!r}, got {line!r}'
    assert len(lines) == len(wanted), f'expected {wanted}, got {lines}'
