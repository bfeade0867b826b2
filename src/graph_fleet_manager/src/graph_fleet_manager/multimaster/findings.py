"""What is found out about another ROS master, judged: is it well, and what is to be done."""
from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import List, Mapping

CLOCK_NOTED = 0.2  # s of difference that age limits of reports begin to feel
CLOCK_WRONG = 1.0  # s that a robot allows a route to come from the future, see the route protocol


class Level(IntEnum):
    """How well it is; the numbers are those of diagnostic_msgs."""

    OK = 0
    WARN = 1
    WRONG = 2


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at: a clause that says what it is like, and what to do."""

    subject: str
    level: Level
    text: str
    advice: str = ''

    def __str__(self) -> str:
        return f'{self.text}: {self.advice}' if self.advice else self.text


def clock_finding(offset: float, uncertainty: float) -> Finding:
    """`offset`: s that the other's clock is ahead of this one, known to `uncertainty` s."""
    off = max(abs(offset) - uncertainty, 0.0)
    level = Level.OK if off < CLOCK_NOTED else Level.WARN if off < CLOCK_WRONG else Level.WRONG
    side = 'ahead of' if offset > 0.0 else 'behind'
    text = (f'its clock is {abs(offset):.3f} s {side} this one (known to {uncertainty:.3f} s)')
    return Finding('clock', level, text, '' if level is Level.OK else
                   'synchronise the clocks of both computers (NTP, chrony)')


def definitions_finding(own: Mapping[str, str], theirs: Mapping[str, str]) -> Finding:
    """Message definitions by type, as MD5 sums; a type without a definition is told, too."""
    different = sorted(kind for kind in own if kind in theirs and theirs[kind] != own[kind])
    missing = sorted(set(own) - set(theirs))
    problems: List[str] = []
    if different:
        problems.append(f'other definitions of {", ".join(different)}')
    if missing:
        problems.append(f'no definitions of {", ".join(missing)}')
    if not problems:
        return Finding('definitions', Level.OK, f'all {len(own)} message definitions are alike')
    return Finding('definitions', Level.WRONG, f'it has {" and ".join(problems)}',
                   'those messages do not cross; build the same version of the workspace on both '
                   'computers')
