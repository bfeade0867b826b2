"""Decides when a state is sent: at once after an important change, otherwise periodically.

A message of the master that changes nothing is also answered with a state, but at most once in
ANSWER_PERIOD. Some masters repeat their order after each state that does not show the order. If the
vehicle answered each refusal with a state, both would send messages without a pause.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Optional

from vda5050_protocol.values import StateMessage

DRIVING_PERIOD = 0.5  # s; a master that connects late receives its first state after this time
IDLE_PERIOD = 5.0     # s; the standard's limit is 30 s
ANSWER_PERIOD = 1.0   # s
EARLY = 0.05          # s that a state may be sent too early: half a period of the caller


class Reporter:
    """Remembers the last state sent."""

    def __init__(self) -> None:
        self._told: Optional[StateMessage] = None
        self._sent = -IDLE_PERIOD
        self._asked = True
        self._answers = False

    def ask(self) -> None:
        """Makes the next state due, even if it has not changed."""
        self._asked = True

    def answer(self) -> None:
        """Makes a state due as the answer to a message of the master; see the module's
        docstring.
        """
        self._answers = True

    def is_due(self, state: StateMessage, now: float) -> bool:
        """Returns whether to send this state; a state that is due counts as sent."""
        events = _events_of(state)
        period = (DRIVING_PERIOD if state.driving else ANSWER_PERIOD if self._answers
                  else IDLE_PERIOD)
        if not self._asked and events == self._told and now - self._sent < period - EARLY:
            return False
        self._asked = self._answers = False
        self._told = events
        self._sent = now
        return True


def _events_of(state: StateMessage) -> StateMessage:
    """Returns the state without the values that change continuously."""
    return replace(state, position=None, velocity=None, distance_since_last_node=None,
                   battery=replace(state.battery, charge=0.0, voltage=None))
