"""omron_controller without ROS and sockets: its cores, joined to a robot by a link with delays."""
from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Callable

from timeline import Timeline

from omron_arcl import Execution, NotConnected, Result, parse_command, parse_line
from omron_arcl.arbiter import Arbiter
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.guard import Guard
from omron_arcl.replies.reply import Reply

HEARTBEAT = 1.5  # s between statuses that it asks for


@dataclass(frozen=True)
class Delays:
    """Seconds that each way takes."""

    commands: float = 0.0        # bridge -> controller
    ends: float = 0.0            # controller -> bridge: how commands end
    lines: float = 0.0           # controller -> bridge: `arcl_response`
    to_robot: float = 0.0        # controller -> robot
    from_robot: float = 0.0      # robot -> controller
    statuses: float = 0.0        # robot -> receiver -> bridge
    to_controller: float = 0.0   # person -> controller
    to_bridge: float = 0.0       # person -> bridge


class ModelledController:
    """Gives commands to a robot, and tells how they end.

    send -- called with each line that comes to the robot
    on_reply -- called with each reply that comes from it
    """

    def __init__(self, timeline: Timeline, delays: Delays, send: Callable[[str], None],
                 on_reply: Callable[[Reply], None]) -> None:
        self.connected = True
        self._timeline = timeline
        self._delays = delays
        self._send_line, self._on_reply = send, on_reply
        self._connection = 0  # number of the link
        self._dispatcher = Dispatcher()
        self._arbiter = Arbiter(
            self._execute, lambda execution: self._dispatcher.cancel(execution, timeline.now),
            Guard(['motion']), lambda: timeline.now)
        timeline.every(HEARTBEAT, self._ask_status)

    def give(self, command: str, giver: str, on_end: Callable[[Result], None]) -> Execution:
        """Gives a command of `giver`; raises ArclError."""
        return self._arbiter.execute(command, giver, on_end=on_end)

    def cancel(self, execution: Execution, canceller: str) -> None:
        """Cancels a command for `canceller`."""
        self._arbiter.cancel(execution, canceller)
        self.turn()

    def turn(self) -> None:
        """What its client does again and again: looks at the clock, sends, tells."""
        self._dispatcher.on_time(self._timeline.now)
        self._send()
        self.call_back()

    def call_back(self) -> None:
        """Tells those who gave commands what has become of them."""
        for call in self._dispatcher.pop_callbacks():
            call()

    def lose_link(self) -> None:
        """Nothing that is under way arrives any more."""
        self.connected = False
        self._connection += 1
        self._dispatcher.on_lost('the link broke')
        self.call_back()

    def say(self, line: str) -> None:
        """The robot says a line."""
        self._carry(self._delays.from_robot, partial(self._hear, line))

    def _hear(self, line: str) -> None:
        reply = parse_line(line)
        self._on_reply(reply)
        self._arbiter.on_reply(reply)
        self._dispatcher.on_reply(reply, line, self._timeline.now)
        self._send()
        self.call_back()

    def _execute(self, text: str, check: Callable, on_end: Callable, **_: object) -> Execution:
        """What the client of ARCL does."""
        command = parse_command(text)
        check(command)
        if not self.connected:
            raise NotConnected('connection refused')
        execution = self._dispatcher.start(command, on_end=on_end)
        self._send()
        return execution

    def _send(self) -> None:
        while self.connected:
            line = self._dispatcher.next_to_send(self._timeline.now)
            if line is None:
                return
            self._carry(self._delays.to_robot, partial(self._send_line, line.decode()))

    def _carry(self, seconds: float, call: Callable[[], None]) -> None:
        connection = self._connection
        if self.connected:
            self._timeline.later(
                seconds, lambda: call() if connection == self._connection else None)

    def _ask_status(self) -> None:
        if self.connected:
            self._dispatcher.start(parse_command('oneLineStatus'))
            self._send()
