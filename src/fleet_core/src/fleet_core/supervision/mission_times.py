"""Missions with an earliest time or a deadline: when they begin, expire, or count as late.

The times are moments (s since 1970), so they stay the same if the clock is set. If the clock is set
back, a mission that has begun or expired stays in that state.
"""
from __future__ import annotations

from math import inf
from typing import Callable, Iterator

from fleet_core.supervision.mission_book import MissionBook, waits_as
from fleet_core.supervision.missions import DeadlineState, Mission, MissionState

NEAR = 10.0    # s: a mission is at risk if it will not end at least this long before its deadline
AGAIN = 30.0   # s: a mission at risk is in time again if it will end this long before its deadline
PERIOD = 1.0   # s between two estimates


def deadline_state(deadline: float, needed: float, now: float, before: DeadlineState,
                   ) -> DeadlineState:
    """Returns whether a mission that is not done yet will be done by its deadline.

    needed -- s that it still needs, as far as is known
    now    -- s since 1970, like the deadline
    before -- the last value that was returned for the mission
    """
    if not deadline:
        return DeadlineState.NONE
    left = deadline - now
    if left < 0.0:
        return DeadlineState.MISSED
    spare = AGAIN if before is DeadlineState.AT_RISK else NEAR
    return DeadlineState.AT_RISK if left - needed < spare else DeadlineState.AHEAD


class MissionTimes:
    """Follows the missions with times.

    clock -- returns ms since 1970
    """

    def __init__(self, book: MissionBook, clock: Callable[[], int]) -> None:
        self._book, self._clock = book, clock
        self._estimated = -inf

    def until_earliest(self, mission: Mission) -> float:
        """Returns the seconds until the earliest time of a mission.

        0: this time has come, or the mission has none.
        """
        return max(mission.request.earliest - self._clock() / 1000.0, 0.0)

    def follow(self, needed: Callable[[Mission], float], now: float) -> Iterator[str]:
        """Lets missions begin or expire. Yields a sentence for each mission that becomes late.

        needed -- returns how many s a mission still needs, as far as is known
        now    -- the supervisor's time
        """
        moment = self._clock() / 1000.0
        is_due = now - self._estimated >= PERIOD
        if is_due:
            self._estimated = now
        for mission in list(self._book.timed.values()):
            request, before = mission.request, mission.deadline_state
            if mission.state is MissionState.PLANNED and moment >= request.earliest:
                self._book.set(mission, *waits_as(request, is_early=False))
            is_missed_now = moment > request.deadline and before is not DeadlineState.MISSED
            if request.deadline and mission.state.is_open and (
                    is_due or is_missed_now or before is DeadlineState.NONE):
                state = self._expect(mission, needed, moment)
                if state is not before and state > DeadlineState.AHEAD:
                    yield _WORDS[state].format(request.id)

    def _expect(self, mission: Mission, needed: Callable[[Mission], float], moment: float,
                ) -> DeadlineState:
        """Notes whether a mission will probably meet its deadline. `moment`: s since 1970."""
        deadline = mission.request.deadline
        time = 0.0 if moment > deadline else self.until_earliest(mission) + needed(mission)
        state = deadline_state(deadline, time, moment, mission.deadline_state)
        self._book.expect(mission, state)
        if state is DeadlineState.MISSED and not mission.has_begun:
            self._book.set(mission, MissionState.EXPIRED, 'its deadline passed before it began')
        return state


_WORDS = {
    DeadlineState.AT_RISK: 'Mission {} will miss its deadline, or its deadline is near.',
    DeadlineState.MISSED: 'Mission {} has missed its deadline.'}
