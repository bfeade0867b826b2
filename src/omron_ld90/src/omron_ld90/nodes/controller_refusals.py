"""What was given and is not carried out: how it is told, and what is too old to be.

A publisher that latches gives its last message to every node that comes later. To carry that out
after a restart of the controller would be to repeat a motion by itself: what was published before
the node started is refused.
"""
from __future__ import annotations

import time
from typing import Callable, Dict, Iterable, Mapping, Optional, Set

import rosgraph
import rospy

from omron_arcl import Outcome, Result, printable
from omron_ld90.nodes.support.log_throttle import warn
from omron_ld90_msgs.msg import CommandRefused

TOO_OLD = ('It was published before the controller started, and is not carried out late: give it '
           'again.')
LATCHED_WITHIN = 5.0  # s from the start in which a latched message may be an old one

# Commands that came to nothing; one that was interrupted or cancelled did not.
_FAILURES: Mapping[Outcome, str] = {
    Outcome.REJECTED: 'was refused by the robot',
    Outcome.NO_GOAL: 'was refused by the robot',
    Outcome.UNKNOWN_COMMAND: 'was refused by the robot',
    Outcome.FAILED: 'failed',
    Outcome.EMERGENCY_STOPPED: 'was ended by the emergency stop',
    Outcome.TIMED_OUT: 'timed out',
    Outcome.LOST: 'was lost',
}


def failure(text: str, result: Result) -> Optional[str]:
    """A sentence for people, where a command came to nothing."""
    if result.outcome not in _FAILURES:
        return None
    return (f'Command {printable(text)!r} {_FAILURES[result.outcome]}: '
            f'{printable(result.words)}.')


class Refusals:
    """Topic `command_refused`, and the same in the log."""

    def __init__(self) -> None:
        self._publisher = rospy.Publisher('command_refused', CommandRefused, queue_size=20,
                                          tcp_nodelay=True)

    def tell(self, text: str, caller: str, reason: str) -> None:
        """What `caller` gave by topic came to nothing for `reason`, a sentence."""
        warn('refused', f'{reason} Asked by {caller}.')
        refusal = CommandRefused(command=printable(text), caller=caller, reason=reason)
        refusal.header.stamp = rospy.Time.now()
        self._publisher.publish(refusal)


class LatchedMessages:
    """Tells which messages were published before this node was there."""

    def __init__(self, publishers: Callable[[str], Iterable[str]],
                 clock: Callable[[], float] = time.monotonic) -> None:
        self._publishers = publishers
        self._clock = clock
        self._until = clock() + LATCHED_WITHIN
        self._earlier: Dict[str, Set[str]] = {}

    def watch(self, topic: str) -> None:
        """Notes who publishes `topic` already; to be called before it is subscribed to."""
        self._earlier[topic] = set(self._publishers(topic))

    def is_old(self, message: rospy.Message, topic: str) -> bool:
        """Whether a message is the last one of a publisher that was there before this node."""
        header = getattr(message, '_connection_header', {})
        earlier, caller = self._earlier.get(topic, set()), header.get('callerid', '')
        old = (header.get('latching') == '1' and caller in earlier
               and self._clock() < self._until)
        earlier.discard(caller)
        return old


def publishers_by_master(topic: str) -> Iterable[str]:
    """The nodes that publish `topic`, by the ROS master."""
    resolved = rospy.resolve_name(topic)
    published, _, _ = rosgraph.Master(rospy.get_name()).getSystemState()
    return [node for name, nodes in published if name == resolved for node in nodes]
