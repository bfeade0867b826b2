"""The errors of this package.

InvalidCommand and NotConnected are mistakes of the caller. LinkError and its subclasses are faults
of the robot or the network. No error ever contains the password.
"""
from __future__ import annotations


class ArclError(Exception):
    """Base of all errors of this package; its text is one sentence for a person."""


class InvalidCommand(ArclError):
    """Text that cannot be sent as one ARCL command; `command` is the text, made printable."""

    def __init__(self, command: str, reason: str) -> None:
        self.command = command
        self.reason = reason
        super().__init__(f'Command {command!r} was not sent: {reason}.')


class NotConnected(ArclError):
    """A command was given without a login at the robot; `reason` says why there is none."""

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(f'Not sent, the robot is not connected: {reason}.')


class StopOwed(NotConnected):
    """A stop was given without a login at the robot; it will be sent."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.args = (f'Not sent yet, the robot is not connected: {reason}. The stop is owed: it is '
                     'sent as soon as the robot can be reached.',)


class Busy(ArclError):
    """`limit` commands have not ended, the most that are kept. No stop is refused for that."""

    def __init__(self, limit: int, commands: str) -> None:
        self.limit = limit
        super().__init__(f'Not sent, {limit} {commands} before it have not ended yet. Wait until '
                         'one has, or give "stop".')


class LinkError(ArclError):
    """The connection could not be made, or it ended."""


class ConnectionFailed(LinkError):
    """The robot could not be reached, or it rejected the connection before the login."""


class WrongPassword(LinkError):
    """The robot refused the password. Robots often close the connection without a message."""


class ConnectionLost(LinkError):
    """The connection ended after the login."""


class PeerSilent(LinkError):
    """Nothing came for `seconds`; `words`: the last text that came in a login."""

    def __init__(self, seconds: float, words: str = '') -> None:
        self.seconds = seconds
        super().__init__(f'nothing was received for {seconds:.1f} s'
                         + (f', after "{words}"' if words else ''))


class LineTooLong(LinkError):
    """The peer sent a line of more than `limit` bytes, the most that is accepted."""

    def __init__(self, limit: int) -> None:
        self.limit = limit
        super().__init__(f'a line of more than {limit} bytes was received')
