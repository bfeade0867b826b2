"""The exceptions for rules that the vehicle breaks, and for rules that cannot be tried."""
from __future__ import annotations

from typing import Any


class Broken(Exception):
    """The vehicle broke a rule; the text says what the bench has observed."""


class NotTried(Exception):
    """The rule could not be tried; the text gives the reason."""


def expect(condition: Any, text: str) -> None:
    """Raises Broken if the condition is false."""
    if not condition:
        raise Broken(text)
