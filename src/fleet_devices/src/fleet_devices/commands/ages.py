"""Ages as texts for people."""
from __future__ import annotations


def age(since: float, now: float) -> str:
    """Returns how long ago a time (s) was."""
    seconds = max(now - since, 0.0)
    if seconds < 120:
        return f'{seconds:.0f} s'
    return f'{seconds / 60:.0f} min' if seconds < 7200 else f'{seconds / 3600:.0f} h'
