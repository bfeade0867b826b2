"""omron_controller without ROS and sockets; a link with delays connects it to a robot."""
from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Callable, Iterable, Optional

from timeline import Timeline

from omron_arcl import Execution, Giver, NotConnected, Result, parse_command, parse_line
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.drives import Drives
from omron_arcl.records import DriveMemory, RobotMotion

HEARTBEAT = 1.5  # s between two requests for a status


@dataclass(frozen=True)
class Delays:
    """The seconds that a message takes, for each sender and receiver."""

    commands: float = 0.0        # bridge -> controller
    ends: float = 0.0  # controller -> bridge: ends of commands
    motions: float = 0.0         # controller -> bridge: `motion`
    to_robot: float = 0.0        # controller -> robot
    from_robot: float = 0.0      # robot -> controller
    statuses: float = 0.0        # robot -> receiver -> bridge
    to_controller: float = 0.0   # person -> controller


class ModelledController:
    """Gives commands to a robot, and reports how they end.

    send -- called with each line that arrives at the robot
    on_motion -- called with each published `RobotMotion`
    """

    def __init__(self, timeline: Timeline, delays: Delays, send: Callable[[str], None],
                 on_motion: Callable[[RobotMotion], None]) -> None:
        self.connected = True
        self._timeline = timeline
        self._delays = delays
        self._send_line, self._on_motion = send, on_motion
        self._connection = 0  # number of the link
        self._stalled_until = -math.inf
        self.on_taken: Callable[[Giver, bool], None] = lambda giver, drives: None
        self._memory: Optional[DriveMemory] = None  # memory that survives the process
        self.start()
        timeline.every(HEARTBEAT, self._ask_status)

    def start(self) -> None:
        """Starts the controller with the memory that its previous process stored."""
        self._told: Optional[RobotMotion] = None
        self._dispatcher = Dispatcher(Drives(self._memory, self._keep))
        if self.connected:
            self._dispatcher.on_connected(self._timeline.now)
        self._tell()

    def _keep(self, memory: DriveMemory) -> None:
        self._memory = memory

    @property
    def records(self) -> Drives:
        """The records of drives."""
        return self._dispatcher.records

    @property
    def motion(self) -> RobotMotion:
        """The published motion, which late subscribers also receive."""
        return self._dispatcher.records.motion

    def give(self, command: str, giver: Giver, known_epoch: int,
             on_end: Callable[[Result], None], number: int = 0) -> Execution:
        """Gives a command of `giver`; raises ArclError."""
        parsed = parse_command(command)
        try:
            if not self.connected:
                self._dispatcher.start_without_link(parsed, giver, known_epoch, number)
                if parsed.spec.stops:
                    self.on_taken(giver, False)
                raise NotConnected('connection refused')
            execution = self._dispatcher.start(parsed, on_end=on_end, giver=giver,
                                               known_epoch=known_epoch, number=number)
            self.on_taken(giver, parsed.spec.drives)
        finally:
            self._tell()
        self._send()
        return execution

    def cancel(self, executions: Iterable[Execution], canceller: Giver) -> None:
        """Cancels all commands on behalf of `canceller`."""
        for execution in executions:
            self._dispatcher.cancel(execution, self._timeline.now, canceller)
        self._dispatcher.records.all_cancelled(canceller)
        self.turn()

    def cancel_own(self, drive: Execution) -> None:
        """Cancels one drive on behalf of its giver."""
        self._dispatcher.cancel(drive, self._timeline.now, drive.giver)
        self.turn()

    def connect(self) -> None:
        """Connects the link again."""
        self.connected = True
        self._dispatcher.on_connected(self._timeline.now)
        self._ask_status()

    def _tell(self) -> None:
        if self.motion != self._told:
            self._told = self.motion
            self._on_motion(self.motion)

    def turn(self) -> None:
        """Makes one turn of the client's loop: checks the clock, sends, reports."""
        self._dispatcher.on_time(self._timeline.now)
        self._send()
        self.call_back()

    def call_back(self) -> None:
        """Reports outcomes to the givers of commands."""
        self._tell()
        for call in self._dispatcher.pop_callbacks():
            call()

    def lose_link(self) -> None:
        """Loses the link: no message on its way arrives any more."""
        self.connected = False
        self._connection += 1
        self._dispatcher.on_lost('the link broke')
        self.call_back()

    def stall(self, seconds: float) -> None:
        """Holds back all lines on the link for some time, and then delivers them at once."""
        self._stalled_until = max(self._stalled_until, self._timeline.now + seconds)

    @property
    def is_stalled(self) -> bool:
        """Whether the link holds lines back."""
        return self._timeline.now < self._stalled_until

    def on_the_way(self, seconds: float) -> float:
        """Returns how long a line takes now; without a stall it takes `seconds`."""
        return max(seconds, self._stalled_until - self._timeline.now)

    def say(self, line: str) -> None:
        """Sends a line of the robot."""
        self.carry(self._delays.from_robot, partial(self._hear, line))

    def _hear(self, line: str) -> None:
        reply = parse_line(line)
        self._dispatcher.on_reply(reply, line, self._timeline.now)
        self._send()
        self.call_back()

    def _send(self) -> None:
        while self.connected:
            line = self._dispatcher.next_to_send(self._timeline.now)
            if line is None:
                return
            self.transmit(line.decode())

    def transmit(self, line: str) -> None:
        """Puts a line on its way to the robot."""
        self.carry(self._delays.to_robot, partial(self._send_line, line))

    def carry(self, seconds: float, call: Callable[[], None],
              lost: Callable[[], None] = lambda: None) -> None:
        """Calls `call` when a line that is sent now arrives, or `lost` if the link breaks first."""
        connection = self._connection if self.connected else None
        self._timeline.later(
            self.on_the_way(seconds),
            lambda: call() if connection == self._connection else lost())

    def _ask_status(self) -> None:
        if self.connected:
            self._dispatcher.start(parse_command('oneLineStatus'))
            self._send()
