"""What keeps a fleet from being started."""


class CannotStart(Exception):
    """Why the fleet cannot be started, and what to do: one sentence."""
