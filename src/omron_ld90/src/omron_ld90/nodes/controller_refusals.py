"""Reports commands that were refused or failed."""
from __future__ import annotations

from typing import Mapping, Optional

import rospy

from node_lifecycle import warn
from omron_arcl import Outcome, Result, printable
from omron_ld90_msgs.msg import CommandRefused

# The words for a failed command. An interruption or a cancellation is not a failure.
_FAILURES: Mapping[Outcome, str] = {
    Outcome.REJECTED: 'was refused by the robot',
    Outcome.NO_GOAL: 'was refused by the robot',
    Outcome.UNKNOWN_COMMAND: 'was refused by the robot',
    Outcome.FAILED: 'failed',
    Outcome.EMERGENCY_STOPPED: 'was ended by the emergency stop',
    Outcome.TIMED_OUT: 'timed out',
    Outcome.LOST: 'was lost',
    Outcome.NEVER_SENT: 'was not sent',
    Outcome.OVERRULED: 'was not sent',
}


def failure(text: str, result: Result) -> Optional[str]:
    """Returns a sentence for a person if the command failed, otherwise None."""
    if result.outcome not in _FAILURES:
        return None
    return (f'Command {printable(text)!r} {_FAILURES[result.outcome]}: '
            f'{printable(result.words)}.')


class Refusals:
    """Publishes refusals and failures on `command_refused`, and logs them."""

    def __init__(self) -> None:
        self._publisher = rospy.Publisher('command_refused', CommandRefused, queue_size=20,
                                          tcp_nodelay=True)

    def refused(self, text: str, caller: str, reason: str) -> None:
        """Reports the failure of a command or pose that came on a topic; `reason` is a sentence."""
        warn('refused', f'{reason} Requested by {caller}.')
        refusal = CommandRefused(command=printable(text), caller=caller, reason=reason)
        refusal.header.stamp = rospy.Time.now()
        self._publisher.publish(refusal)
