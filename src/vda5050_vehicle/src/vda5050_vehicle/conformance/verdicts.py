"""What becomes of a rule that is tried and not kept."""
from __future__ import annotations

from typing import Any


class Broken(Exception):
    """The vehicle broke a rule; the text says what was seen."""


class NotTried(Exception):
    """The rule could not be tried; the text says why."""


def expect(condition: Any, text: str) -> None:
    """Raises Broken unless the condition holds."""
    if not condition:
        raise Broken(text)
