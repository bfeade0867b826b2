"""What rules are made of, and the list of them."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Callable, List, Tuple

from vda5050_vehicle.conformance.trial import Trial

ALL = ('2.', '3.')        # versions of the standard
SINCE_2_1 = ('2.1', '3.')  # figure 8 of 2.0 asks for nodes and edges and actions that are left
ONLY_3 = ('3.',)


class Level(Enum):
    """How much the standard demands it."""

    MUST = 'must'
    SHOULD = 'should'


class Start(Enum):
    """What a rule needs before it is tried."""

    NOTHING = 'nothing'    # it looks at what was said
    ANYWHERE = 'anywhere'  # the vehicle is without an order if that can be had
    AT_END = 'at an end'   # without an order, at an end of the track


@dataclass(frozen=True)
class Rule:
    """A rule: the sentence of the standard that it checks, where that stands, how it is tried."""

    level: Level
    section: str
    sentence: str
    start: Start
    versions: Tuple[str, ...]
    attempt: Callable[[Trial], None]


Attempt = Callable[[Trial], None]
RULES: List[Rule] = []


def must(section: str, sentence: str, start: Start = Start.AT_END,
         versions: Tuple[str, ...] = ALL) -> Callable[[Attempt], Attempt]:
    """Adds a function to the rules; `section` is of 2.1.0, or of 3.0.0 where only that has it."""
    return _rule(Level.MUST, section, sentence, start, versions)


def should(section: str, sentence: str, start: Start = Start.AT_END,
           versions: Tuple[str, ...] = ALL) -> Callable[[Attempt], Attempt]:
    """The same for what the standard recommends."""
    return _rule(Level.SHOULD, section, sentence, start, versions)


def rules_of(version: str) -> List[Rule]:
    """Those that a version of the standard has."""
    return [rule for rule in RULES if version.startswith(rule.versions)]


def _rule(level: Level, section: str, sentence: str, start: Start,
          versions: Tuple[str, ...]) -> Callable[[Attempt], Attempt]:
    def add(attempt: Attempt) -> Attempt:
        RULES.append(Rule(level, section, sentence, start, versions, attempt))
        return attempt
    return add
