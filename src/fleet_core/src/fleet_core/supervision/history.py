"""The history of all missions. Programs read it from the supervisor's journal."""
from __future__ import annotations

import math
import os
import sqlite3
from typing import Callable, Iterator, List, NamedTuple, Optional, Tuple
from urllib.parse import quote

from fleet_core.supervision.journal import OPEN_STATES, read_request
from fleet_core.supervision.journal_database import JournalError, NoJournal
from fleet_core.supervision.missions import MissionState, short_name

_PAGE = 1000  # number of missions that are read at a time


class HistoryLine(NamedTuple):
    """One mission in the history. Times are in s since 1970; None: it did not happen.

    Each attribute is a column of the history.
    """

    request_id: int
    destinations: Tuple[int, ...]
    robot_type: str
    priority: int
    state: MissionState
    robot: str
    reached: int
    accepted: float
    started: Optional[float]
    ended: Optional[float]
    reason: str
    requested_by: str = ''
    serial: int = 0

    @property
    def waited(self) -> Optional[float]:
        """s from acceptance to start, or to the end if it never started; None: still waiting."""
        begun = self.started if self.started is not None else self.ended
        return None if begun is None else begun - self.accepted

    @property
    def took(self) -> Optional[float]:
        """s from start to end; None: it has not started, or has not ended."""
        return None if self.started is None or self.ended is None else self.ended - self.started


HISTORY_COLUMNS = ('request_id', 'destinations', 'robot_type', 'priority', 'state', 'robot',
                   'reached', 'accepted', 'started', 'ended', 'waited_s', 'took_s', 'reason',
                   'requested_by', 'mission')
"""The columns of the history as CSV."""


def row_of(line: HistoryLine, moment: Callable[[float], str]) -> List[str]:
    """Returns the texts of HISTORY_COLUMNS. `moment` writes a time (s since 1970)."""
    def written(time: Optional[float]) -> str:
        return '' if time is None else moment(time)

    def seconds(length: Optional[float]) -> str:
        return '' if length is None else f'{length:.1f}'
    return [str(line.request_id), ' '.join(map(str, line.destinations)), line.robot_type,
            str(line.priority), line.state.name, line.robot, str(line.reached),
            written(line.accepted), written(line.started), written(line.ended),
            seconds(line.waited), seconds(line.took), line.reason, line.requested_by,
            short_name(line.serial)]


def history(path: str, since: float = -math.inf) -> Iterator[HistoryLine]:
    """Yields all missions in the history, read page by page. The supervisor may still write.

    Raises NoJournal if there is no such file, and JournalError if it is no journal.

    since -- s since 1970; omits missions that ended before and did not change later
    """
    wanted = '' if since == -math.inf else f'AND (changed >= :since OR state IN {OPEN_STATES})'
    if not os.path.isfile(path):
        raise NoJournal(f'There is no journal {path}: no mission was ever accepted on this '
                           'computer, or it is kept elsewhere.')
    try:
        db, unchanged = _opened(path)
        try:
            last = 0
            while True:
                rows = db.execute(
                    'SELECT m.serial, m.request, m.state, m.robot, m.reached, m.reason, '
                    'MIN(c.time), MIN(CASE WHEN c.state = :active THEN c.time END), MAX(c.time) '
                    f'FROM (SELECT * FROM mission WHERE serial > :last {wanted} '
                    'ORDER BY serial LIMIT :page) m '
                    'JOIN change c USING (serial) GROUP BY serial ORDER BY serial',
                    {'active': int(MissionState.ACTIVE), 'last': last, 'since': since,
                     'page': _PAGE}).fetchall()
                if not unchanged():
                    raise JournalError(f'The journal {path} was written while it was read: try '
                                       'again.')
                yield from (_history_line(*row) for row in rows)
                if len(rows) < _PAGE:
                    return
                last = rows[-1][0]
        finally:
            db.close()
    except sqlite3.Error as error:
        raise JournalError(f'The journal {path} cannot be read ({error}).') from None


def _opened(path: str) -> Tuple[sqlite3.Connection, Callable[[], bool]]:
    """Opens a journal for reading.

    The second value is a function. It returns whether all data that were read belong to one moment.
    SQLite ensures this with files beside the journal, but cannot make these files in a folder that
    this process may not write. If no supervisor has made them either, the function checks whether
    the journal file has changed.
    """
    address = f'file:{quote(os.path.abspath(path))}?mode=ro'
    if os.path.exists(f'{path}-wal') or os.access(os.path.dirname(os.path.abspath(path)), os.W_OK):
        return sqlite3.connect(address, uri=True, timeout=2.0), lambda: True

    def version() -> Tuple[int, int, int]:
        status = os.stat(path)
        return status.st_ino, status.st_size, status.st_mtime_ns
    before = version()
    return (sqlite3.connect(f'{address}&immutable=1', uri=True),
            lambda: version() == before)


def _history_line(serial: int, text: str, number: int, robot: str, reached: int, reason: str,
                  accepted: float, started: Optional[float], last: float) -> HistoryLine:
    request, state = read_request(text), MissionState(number)
    return HistoryLine(request.id, request.destinations, request.robot_type, request.priority,
                       state, robot, reached, accepted, started, None if state.is_open else last,
                       reason, request.requested_by, serial)
