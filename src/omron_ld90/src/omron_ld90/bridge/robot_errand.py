"""What we told the robot, and which of its words answer that.

ARCL has no request ids, and everybody hears when anybody sends the robot somewhere. So the goals
that we sent are kept until the robot says that it is going there; a goal that it names and that we
did not send is somebody else's.
"""
from __future__ import annotations

from typing import FrozenSet, Iterable, List, Optional

from omron_ld90.bridge.route_protocol import Docking

STOP = 'stop'
DOCK = 'dock'
LONGEST_NAME = 16  # characters to which robots cut the name of a command that they do not know


class RobotErrand:
    """The goal that the robot was last sent to by us, and whether it is still about that."""

    def __init__(self) -> None:
        self.goal: Optional[str] = None
        """Name of the goal last sent; DOCK for the dock, None when we have sent it nowhere."""
        self.reached = False
        """Whether the robot has said that it is there."""
        self.docking: Optional[Docking] = None
        """The docking state last heard of."""
        self._command = ''
        self._via: FrozenSet[str] = frozenset()
        self._awaited: List[str] = []  # sent, but the robot has not said that it is going there
        self._outbox: List[str] = []

    @property
    def confirmed(self) -> bool:
        """Whether the robot has taken up the last goal."""
        return self.goal is not None and not self._awaited

    def send(self, command: str, goal: str, via: Iterable[str] = ()) -> None:
        """Sends the robot to `goal` (a goal's name, or DOCK), over the goals `via`."""
        self.goal = goal
        self.reached = False
        self._command = command
        self._via = frozenset(via)
        self._awaited.append(goal)
        self._outbox.append(command)

    def stop(self) -> None:
        """Stops the robot, wherever it is going."""
        self.end()
        self._outbox.append(STOP)

    def end(self) -> None:
        """We have no more business with the robot."""
        self.goal = None
        self.reached = False
        self._awaited.clear()

    def take_commands(self) -> List[str]:
        """The commands to give the robot, once."""
        commands, self._outbox = self._outbox, []
        return commands

    # --- what the robot says: was that us? -------------------------------------------------------

    def started(self, goal: str) -> bool:
        """The robot says that it is going to `goal`; False when somebody else sent it there."""
        if goal in self._awaited:
            del self._awaited[:self._awaited.index(goal) + 1]
        elif goal in self._via:
            self._awaited.clear()
        else:
            return goal == self.goal or self._may_be_dock(goal)
        return True

    def arrived(self, goal: str) -> bool:
        """The robot says that it is at `goal`; whether that is the goal last sent."""
        if goal != self.goal:
            return False
        self._awaited.clear()
        self.reached = True
        return True

    def interrupted(self, text: str) -> bool:
        """The robot says that it no longer does `text`; False when no command of ours did that."""
        about_goal = self.goal == DOCK or text.split()[-1:] == [self.goal]
        return bool(self._awaited) or self.reached or not about_goal

    def shown(self, goal: str) -> bool:
        """The status text names `goal`; False when we know of no reason for that."""
        return (goal == self.goal or goal in self._via or not self.confirmed
                or self._may_be_dock(goal))

    def docking_changed(self, state: Docking) -> bool:
        """The docking state was told; False when the robot docks without our having asked."""
        before, self.docking = self.docking, state
        if self.goal == DOCK and state in (Docking.DOCKING, Docking.DOCKED):
            self._awaited.clear()
            self.reached = state is Docking.DOCKED
            return True
        return state is not Docking.DOCKING or before in (None, state) or not self.confirmed

    def _may_be_dock(self, goal: str) -> bool:
        """Is this how the robot calls its way to the dock? Vertices have numbers for names."""
        return self.goal == DOCK and not goal.isdecimal()

    def is_ours(self, command: str) -> bool:
        """Is this our last command, in full or (a robot that does not know it) its first word?"""
        words = self._command.split()
        return bool(words) and command.split() in (words, [words[0][:LONGEST_NAME]], words[:1])
