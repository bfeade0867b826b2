"""The errors of this package.

InvalidCommand and NotConnected are mistakes of the caller. LinkError and its subclasses are faults
of the robot or the network. No error ever contains the password.
"""
from __future__ import annotations


class ArclError(Exception):
    """Base of all errors of this package; its text is one sentence for a person."""


class InvalidCommand(ArclError):
    """A text that cannot be sent as one ARCL command. `command` is the text in printable form."""

    def __init__(self, command: str, reason: str) -> None:
        self.command = command
        self.reason = reason
        super().__init__(f'Command {command!r} was not sent: {reason}.')


class NotConnected(ArclError):
    """A command was given while no login at the robot exists; `reason` says why."""

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(f'Not sent, the robot is not connected: {reason}.')


class StopOwed(NotConnected):
    """A stop was given while no login at the robot exists. It will be sent after the next login."""

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.args = (f'Not sent yet, the robot is not connected: {reason}. The stop is owed: it is '
                     'sent as soon as the robot can be reached.',)


class Busy(ArclError):
    """The maximum number of commands (`limit`) is under way. A stop never gets this error."""

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
    """No line came for `seconds`. `words` is the last text that came during the login."""

    def __init__(self, seconds: float, words: str = '') -> None:
        self.seconds = seconds
        super().__init__(f'nothing was received for {seconds:.1f} s'
                         + (f', after "{words}"' if words else ''))


class LineTooLong(LinkError):
    """The peer sent a line longer than the accepted maximum of `limit` bytes."""

    def __init__(self, limit: int) -> None:
        self.limit = limit
        super().__init__(f'a line of more than {limit} bytes was received')
