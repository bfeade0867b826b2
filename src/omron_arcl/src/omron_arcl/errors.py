"""What can go wrong, by whose fault.

InvalidCommand and NotConnected are the caller's, LinkError and its kinds the robot's or the
network's. None of them ever holds the password.
"""
from __future__ import annotations


class ArclError(Exception):
    """Base of all errors of this package; its text is one sentence for people."""


class InvalidCommand(ArclError):
    """Text that cannot be sent as one ARCL command; `command` is the text, made printable."""

    def __init__(self, command: str, reason: str) -> None:
        self.command = command
        self.reason = reason
        super().__init__(f'Command {command!r} was not sent: {reason}.')


class NotConnected(ArclError):
    """A command was given without a login at the robot; `reason` tells why not."""

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(f'Not sent, the robot is not connected: {reason}.')


class Busy(ArclError):
    """More commands wait to be sent than the robot can be expected to take."""


class LinkError(ArclError):
    """The connection could not be made or ended."""


class ConnectionFailed(LinkError):
    """The robot could not be reached, or turned the connection down before the login."""


class WrongPassword(LinkError):
    """The robot closed the connection on the password, which it does without a word."""


class ConnectionLost(LinkError):
    """The connection ended after the login."""


class PeerSilent(LinkError):
    """Nothing came for too long; `seconds` is how long, `words` what came last in a login."""

    def __init__(self, seconds: float, words: str = '') -> None:
        self.seconds = seconds
        super().__init__(f'nothing was received for {seconds:.1f} s'
                         + (f', after "{words}"' if words else ''))


class LineTooLong(LinkError):
    """The peer sent a line beyond all measure; `limit` is the most bytes that are taken."""

    def __init__(self, limit: int) -> None:
        self.limit = limit
        super().__init__(f'a line of more than {limit} bytes was received')
