"""The error for a fleet that cannot be started."""


class CannotStart(Exception):
    """The fleet cannot be started. The text is one sentence that says why and what to do."""
