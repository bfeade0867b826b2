"""The structure of a rule, and the list of all rules."""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Callable, List, Tuple

from vda5050_bench.trial import Trial

ALL = ('2.', '3.')        # versions of the standard
SINCE_2_1 = ('2.1', '3.')  # in figure 8 of 2.0, only nodes, edges and actions make a vehicle busy
ONLY_2 = ('2.',)
ONLY_3 = ('3.',)


class RuleLevel(Enum):
    """The level of obligation in the standard."""

    MUST = 'must'
    SHOULD = 'should'
    DERIVED = 'derived'  # no sentence demands it, but the standard implies it


class Start(Enum):
    """The condition that a rule requires before it is tried."""

    NOTHING = 'nothing'    # no condition; the rule evaluates messages that came
    ANYWHERE = 'anywhere'  # the vehicle has no order, if that is possible
    AT_END = 'at an end'   # the vehicle has no order and stands at an end of the track


@dataclass(frozen=True)
class BenchRule:
    """A rule: the sentence of the standard that it checks, its section, and its test function."""

    level: RuleLevel
    section: str
    sentence: str
    start: Start
    versions: Tuple[str, ...]
    attempt: Callable[[Trial], None]


Attempt = Callable[[Trial], None]
RULES: List[BenchRule] = []


def must(section: str, sentence: str, start: Start = Start.AT_END,
         versions: Tuple[str, ...] = ALL) -> Callable[[Attempt], Attempt]:
    """Adds a function to the rules.

    section -- section of 2.1.0, or of 3.0.0 if only 3.0.0 has the rule
    """
    return _rule(RuleLevel.MUST, section, sentence, start, versions)


def should(section: str, sentence: str, start: Start = Start.AT_END,
           versions: Tuple[str, ...] = ALL) -> Callable[[Attempt], Attempt]:
    """Does the same as `must`, for a recommendation of the standard."""
    return _rule(RuleLevel.SHOULD, section, sentence, start, versions)


def derived(section: str, sentence: str, start: Start = Start.AT_END,
            versions: Tuple[str, ...] = ALL) -> Callable[[Attempt], Attempt]:
    """Does the same as `must`, for a rule that the standard does not state but implies."""
    return _rule(RuleLevel.DERIVED, section, sentence, start, versions)


def rules_of(version: str) -> List[BenchRule]:
    """Returns the rules of a version of the standard."""
    return [rule for rule in RULES if version.startswith(rule.versions)]


def _rule(level: RuleLevel, section: str, sentence: str, start: Start,
          versions: Tuple[str, ...]) -> Callable[[Attempt], Attempt]:
    def add(attempt: Attempt) -> Attempt:
        RULES.append(BenchRule(level, section, sentence, start, versions, attempt))
        return attempt
    return add
