"""What rules are made of: the list of them, their outcomes, and what several of them look at."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, List

from vda5050_vehicle.conformance.master import Master, error_types

if TYPE_CHECKING:
    from vda5050_vehicle.conformance.bench import Bench

QUICK = 3.0  # s in which a vehicle answers
QUIET = 1.0  # s in which it must not


class Broken(Exception):
    """The vehicle broke a rule; the text says what was seen."""


class NotTried(Exception):
    """The rule could not be tried; the text says why."""


@dataclass(frozen=True)
class Rule:
    """A rule, where it stands in the standard, and how it is tried."""

    section: str
    title: str
    attempt: Callable[[Bench], None]


RULES: List[Rule] = []


def rule(section: str, title: str) -> Callable[[Callable[[Bench], None]], Callable[[Bench], None]]:
    """Adds a function to the rules."""
    def add(attempt: Callable[[Bench], None]) -> Callable[[Bench], None]:
        RULES.append(Rule(section, title, attempt))
        return attempt
    return add


def expect(condition: Any, text: str) -> None:
    """Raises Broken unless the condition holds."""
    if not condition:
        raise Broken(text)


def rejected(master: Master, before: int, kinds: str, what: str) -> None:
    """An error of one of these kinds comes, and nothing else changes."""
    was = master.messages['state'][before - 1]
    names = kinds.split()
    state = master.wait(lambda state: set(names) & set(error_types(state)), QUICK,
                        f'{" or ".join(names)} for {what}', after=before)
    for error in state['errors']:
        if error['errorType'] in names:
            expect(error['errorLevel'] == 'WARNING', f'{what}: the errorLevel is not WARNING')
    for key in ('orderId', 'orderUpdateId'):
        expect(state[key] == was[key], f'{what}: {key} has changed from {was[key]!r}')
