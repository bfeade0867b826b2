"""The message that ends a start: it says which robots are ready, so that people can begin."""
from __future__ import annotations

from typing import Mapping, Optional

from fleet_core.supervision.fleet_view import RobotState

LIMIT = 30.0  # s after the first news of the fleet within which all robots should be ready
_READY = (RobotState.IDLE, RobotState.BUSY, RobotState.CHARGING)
_NOT_WANTED = (RobotState.ABSENT, RobotState.OUT_OF_SERVICE)  # a person has declared this


class Readiness:
    """The message that the fleet is ready. It is made only once."""

    def __init__(self) -> None:
        self._since: Optional[float] = None
        self._is_told = False

    def words(self, robots: Mapping[str, RobotState], is_surveyed: bool, is_stopped: bool,
              now: float) -> str:
        """Returns the sentences that say that the fleet is ready.

        Empty: they were returned before, or some robots may still become ready.

        robots      -- the states of the robots, by name
        is_surveyed -- whether the survey of the graph, which logs several lines, has ended
        now         -- time of these news, in s
        """
        if self._is_told:
            return ''
        self._since = now if self._since is None else self._since
        known = {name: state for name, state in robots.items() if state not in _NOT_WANTED}
        awaited = [f'{name} ({state.words})' for name, state in known.items()
                   if state not in _READY]
        if not known or ((awaited or not is_surveyed) and now - self._since < LIMIT):
            return ''
        self._is_told = True
        ready = len(known) - len(awaited)
        told = f'Ready: {ready} robot{"" if ready == 1 else "s"}.'
        if awaited:
            told += f' Not ready: {", ".join(awaited)}.'
        return told + (' The fleet is stopped: press Go on.' if is_stopped else '')
