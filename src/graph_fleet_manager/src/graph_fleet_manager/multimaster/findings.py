"""Findings about another ROS master: a level and advice for each check."""
from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import List, Mapping

CLOCK_NOTED = 0.2  # s; a larger difference affects the age limits of reports
CLOCK_WRONG = 1.0  # s that a route's stamp may be ahead of the robot's clock, see route protocol


class Grade(IntEnum):
    """The level of a finding; the numbers are those of diagnostic_msgs."""

    OK = 0
    WARN = 1
    WRONG = 2


@dataclass(frozen=True)
class Checked:
    """The result of one check: `text` is a clause about the state, `advice` says what to do."""

    subject: str
    level: Grade
    text: str
    advice: str = ''

    def __str__(self) -> str:
        return f'{self.text}: {self.advice}' if self.advice else self.text


def clock_finding(offset: float, uncertainty: float) -> Checked:
    """Returns the finding about a clock that is `offset` s ahead of this computer's clock. The
    error of `offset` is at most `uncertainty` s.
    """
    off = max(abs(offset) - uncertainty, 0.0)
    level = Grade.OK if off < CLOCK_NOTED else Grade.WARN if off < CLOCK_WRONG else Grade.WRONG
    side = 'ahead of' if offset > 0.0 else 'behind'
    text = (f'its clock is {abs(offset):.3f} s {side} this one (known to {uncertainty:.3f} s)')
    return Checked('clock', level, text, '' if level is Grade.OK else
                   'synchronise the clocks of both computers (NTP, chrony)')


def definitions_finding(own: Mapping[str, str], theirs: Mapping[str, str]) -> Checked:
    """Returns the finding about differing or missing definitions; `own`, `theirs`: MD5 sums by
    type.
    """
    different = sorted(kind for kind in own if kind in theirs and theirs[kind] != own[kind])
    missing = sorted(set(own) - set(theirs))
    problems: List[str] = []
    if different:
        problems.append(f'other definitions of {", ".join(different)}')
    if missing:
        problems.append(f'no definitions of {", ".join(missing)}')
    if not problems:
        return Checked('definitions', Grade.OK, f'all {len(own)} message definitions are alike')
    return Checked('definitions', Grade.WRONG, f'it has {" and ".join(problems)}',
                   'those messages are not transferred; build the same version of the workspace '
                   'on both computers')
