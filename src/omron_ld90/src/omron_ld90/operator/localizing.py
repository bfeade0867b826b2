"""Localizes a robot at a place that a person names: asks first, then checks the robot's score."""
from __future__ import annotations

from typing import NamedTuple, Optional, Tuple

from omron_arcl import Reply
from omron_arcl.replies import LocalizationScore, OneLineStatus
from omron_ld90.operator.notices import NoticeSeverity, OperatorNotice

LOW_SCORE = 0.2   # 0 to 1; with a lower score, the scan does not fit the map: the place is wrong
SCORE_WITHIN = 5.0  # s within which a robot reports its score, which comes with each status

ASKED_FOR = 15.0  # s within which the person may answer the question

Place = Tuple[float, float]
"""x, y in m, in the map."""


class Judged(NamedTuple):
    """The notice about a localized robot, and the place to which it belongs."""

    notice: OperatorNotice
    place: Optional[Place]


class _Awaited(NamedTuple):
    """The robot's report that it is localized: words, place, and time of the report."""

    words: str
    place: Optional[Place]
    since: float


class LocalizeQuestion:
    """Asks a person before a robot is localized: with a wrong pose, the robot may collide."""

    def __init__(self) -> None:
        self._asked: Optional[Tuple[Place, float]] = None

    def is_confirmed(self, place: Place, now: float) -> bool:
        """Returns whether the person has chosen this place a second time within ASKED_FOR s.

        If this is the first choice of the place, notes it with the time `now` (s): the person must
        then choose the same place again.
        """
        asked, self._asked = self._asked, (place, now)
        if asked is None or asked[0] != place or now - asked[1] > ASKED_FOR:
            return False
        self._asked = None
        return True

    def forget(self) -> None:
        """Forgets the first choice, because the person has done something else."""
        self._asked = None


class LocalizingWatch:
    """Waits for the score of a robot that has reported that it is localized. Times are in s."""

    def __init__(self) -> None:
        self._awaited: Optional[_Awaited] = None

    def begin(self, words: str, place: Optional[Place], now: float) -> None:
        """Notes that the robot has reported that it is localized. Its next score checks this."""
        self._awaited = _Awaited(words, place, now)

    def observe(self, reply: Reply) -> Optional[Judged]:
        """Takes a reply of the robot. Returns the notice if the reply has the awaited score."""
        score = reply.localization_score if isinstance(reply, OneLineStatus) else reply
        return self._judged(score.score) if isinstance(score, LocalizationScore) else None

    def check(self, now: float) -> Optional[Judged]:
        """Returns the notice if the robot has not reported its score in time."""
        awaited = self._awaited
        is_late = awaited is not None and now - awaited.since > SCORE_WITHIN
        return self._judged(None) if is_late else None

    def _judged(self, score: Optional[float]) -> Optional[Judged]:
        awaited, self._awaited = self._awaited, None
        return None if awaited is None else Judged(_localized(awaited.words, score), awaited.place)


def _localized(words: str, score: Optional[float]) -> OperatorNotice:
    if score is None:
        return OperatorNotice(NoticeSeverity.INFO,
                              f'{words}, but the robot does not report how well that fits: '
                              'compare its laser points with the walls.')
    if score < LOW_SCORE:
        return OperatorNotice(NoticeSeverity.BAD,
                              f'{words}, but the score is {score:.2f}, so the robot is '
                              'probably elsewhere: localize it again before it drives.')
    return OperatorNotice(NoticeSeverity.GOOD, f'{words}, score {score:.2f}')
