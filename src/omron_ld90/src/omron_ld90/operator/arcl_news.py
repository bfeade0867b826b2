"""Which of the robot's lines are news for the person at the screen, and how good they are."""
from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Callable, Dict, Optional, Type

import omron_arcl as arcl


class Tone(enum.Enum):
    """How good a piece of news is."""

    NEWS = 'news'
    GOOD = 'good'
    BAD = 'bad'


@dataclass(frozen=True)
class News:
    """A sentence for people; `goal` is the goal it is about, if there is one."""

    tone: Tone
    text: str
    goal: Optional[str] = None


TELLERS: Dict[Type, Callable[..., News]] = {
    arcl.replies.GoingTo: lambda line: News(Tone.NEWS, f'Going to {line.goal}', line.goal),
    arcl.replies.GoingToPoint: lambda line: News(Tone.NEWS, 'Going to the point'),
    arcl.replies.ArrivedAt: lambda line: News(Tone.GOOD, f'Arrived at {line.goal}', line.goal),
    arcl.replies.ArrivedAtPoint: lambda line: News(Tone.GOOD, 'Arrived at the point'),
    arcl.replies.Stopped: lambda line: News(Tone.NEWS, 'Stopped'),
    arcl.replies.Interrupted: lambda line: News(Tone.NEWS, f'Interrupted: {line.text}'),
    arcl.replies.RobotError: lambda line: News(Tone.BAD, f'Error: {line.text}'),
    arcl.replies.CommandErrorDescription: lambda line: News(Tone.BAD, line.text),
    arcl.replies.UnknownCommand: lambda line: News(
        Tone.BAD, f'The robot does not know {line.name}'),
    arcl.replies.EStop: lambda line: News(Tone.BAD, 'Emergency stop'),
    arcl.replies.MapChanged: lambda line: News(Tone.NEWS, 'The robot loaded another map'),
}


class NewsReader:
    """Picks the news out of the robot's lines; the docking state is news only when it changes."""

    def __init__(self) -> None:
        self._docking: Optional[arcl.replies.DockingState] = None

    def read(self, line: str) -> Optional[News]:
        """The news in one line of the robot, or None."""
        reply = arcl.parse_line(line)
        if isinstance(reply, arcl.replies.DockingStatus):
            return self._read_docking(reply.docking)
        teller = TELLERS.get(type(reply))
        return teller(reply) if teller else None

    def _read_docking(self, state: arcl.replies.DockingState) -> Optional[News]:
        known, self._docking = self._docking, state
        if known in (None, state):
            return None
        tone = Tone.GOOD if state is arcl.replies.DockingState.DOCKED else Tone.NEWS
        return News(tone, state.name.capitalize())
