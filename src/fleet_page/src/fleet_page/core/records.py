"""The records of the page: acts and their requesters, favourites, areas, the history's sums, and
the events and the battery of each robot."""
from __future__ import annotations

import json
import sqlite3
from dataclasses import asdict, astuple, dataclass
from enum import Enum
from typing import Any, Dict, Iterable, List, Mapping, Tuple

from fleet_page.core.acts import Act, ActOutcome
from fleet_page.core.robot_events import RobotEvent

MOST_ROWS = 50000       # rows of the audit list, at most; the oldest ones are deleted
MOST_NAMED = 100        # largest number of favourites, and of areas
HOUR = 3600
KEPT_HOURS = 24 * 90
CHARGE_PERIOD = 300     # s between two values of a battery
KEPT_CHARGE = 24 * HOUR  # s after which a value is deleted
KEPT_EVENTS = 20000      # events of all robots together; the oldest ones are deleted
_TABLES = '''
CREATE TABLE IF NOT EXISTS audit (
    id INTEGER PRIMARY KEY, time REAL NOT NULL, person TEXT NOT NULL, act TEXT NOT NULL,
    details TEXT NOT NULL, ok INTEGER NOT NULL, outcome TEXT NOT NULL, mission INTEGER NOT NULL);
CREATE INDEX IF NOT EXISTS audit_by_mission ON audit (mission);
CREATE TABLE IF NOT EXISTS favourite (name TEXT PRIMARY KEY, content TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS area (name TEXT PRIMARY KEY, content TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS robot_hour (
    hour INTEGER NOT NULL, robot TEXT NOT NULL, distance REAL NOT NULL, busy REAL NOT NULL,
    waiting REAL NOT NULL, watched REAL NOT NULL, PRIMARY KEY (hour, robot));
CREATE TABLE IF NOT EXISTS edge_hour (
    hour INTEGER NOT NULL, edge INTEGER NOT NULL, waiting REAL NOT NULL, PRIMARY KEY (hour, edge));
CREATE TABLE IF NOT EXISTS robot_charge (
    robot TEXT NOT NULL, period INTEGER NOT NULL, charge REAL NOT NULL,
    PRIMARY KEY (robot, period));
CREATE TABLE IF NOT EXISTS robot_event (
    id INTEGER PRIMARY KEY, time REAL NOT NULL, robot TEXT NOT NULL, state TEXT NOT NULL,
    outage TEXT NOT NULL, works INTEGER NOT NULL, alarm TEXT NOT NULL, waits_for TEXT NOT NULL,
    mission INTEGER);
CREATE INDEX IF NOT EXISTS robot_event_by_robot ON robot_event (robot);
'''


class NamedKind(Enum):
    """The kinds of things that users store by name; the value is the name of the table."""

    FAVOURITE = 'favourite'
    """A mission."""
    AREA = 'area'
    """Edges that are closed and opened as one."""


class TooManyNamed(Exception):
    """The number of stored favourites or areas has reached its limit."""


@dataclass
class Sums:
    """Sums for one robot.

    distance -- m driven
    busy     -- s with a mission
    waiting  -- s of `busy` in which the robot waited
    watched  -- s in which the page received the robot's state
    """

    distance: float = 0.0
    busy: float = 0.0
    waiting: float = 0.0
    watched: float = 0.0


@dataclass(frozen=True)
class HistorySums:
    """The sums of each robot, and the waiting time (s) of robots on each edge, longest first."""

    robots: Dict[str, Sums]
    edges: List[Tuple[int, float]]


class Records:
    """The records in one SQLite file (`:memory:`: in no file). One thread at a time uses them.

    There are methods for each kind of record, because no other class reads or writes the file.
    """

    def __init__(self, path: str) -> None:
        self._db = sqlite3.connect(path, isolation_level=None, timeout=1.0,
                                   check_same_thread=False)
        self._db.execute('PRAGMA journal_mode=WAL')
        self._db.executescript(_TABLES)

    def close(self) -> None:
        """Closes the file."""
        self._db.close()

    # -- audit ------------------------------------------------------------------------------------

    def note(self, time: float, person: str, act: Act, outcome: ActOutcome) -> None:
        """Adds a person's request and its outcome to the audit list."""
        details = {name: value for name, value in asdict(act).items() if value and name != 'kind'}
        self._db.execute('INSERT INTO audit VALUES (NULL, ?, ?, ?, ?, ?, ?, ?)', (
            time, person, act.kind.value, json.dumps(details), outcome.ok, outcome.text,
            outcome.mission))
        self._db.execute('DELETE FROM audit WHERE id <= (SELECT MAX(id) FROM audit) - ?',
                         (MOST_ROWS,))

    def mission_became(self, mission: int, words: str) -> None:
        """Replaces, in the audit list, the outcome of the request that led to a mission."""
        self._db.execute('UPDATE audit SET outcome = ? WHERE id = '
                         '(SELECT MAX(id) FROM audit WHERE mission = ?)', (words, mission))

    def was_not_done(self, act: str, mission: int, words: str) -> None:
        """Notes that the fleet manager did not carry out the last act of this kind on a mission."""
        self._db.execute(
            'UPDATE audit SET ok = 0, outcome = ? WHERE id = (SELECT MAX(id) FROM audit WHERE '
            "act = ? AND json_extract(details, '$.mission') = ?)", (words, act, mission))

    def audit(self, most: int) -> List[Dict[str, Any]]:
        """Returns at most this number of rows of the audit list, the newest first."""
        rows = self._db.execute('SELECT time, person, act, details, ok, outcome FROM audit '
                                'ORDER BY id DESC LIMIT ?', (most,))
        return [{'time': time, 'person': person, 'act': act, 'details': json.loads(details),
                 'ok': bool(ok), 'outcome': outcome}
                for time, person, act, details, ok, outcome in rows]

    # -- favourites and areas ---------------------------------------------------------------------

    def keep_named(self, kind: NamedKind, name: str, content: Mapping[str, Any]) -> None:
        """Stores a favourite or an area under a name. Raises TooManyNamed."""
        known = self.named(kind)
        if len(known) >= MOST_NAMED and name not in known:
            raise TooManyNamed
        self._db.execute(f'INSERT OR REPLACE INTO {kind.value} VALUES (?, ?)',
                         (name, json.dumps(content)))

    def remove_named(self, kind: NamedKind, name: str) -> bool:
        """Removes a favourite or an area. Returns whether it existed."""
        return self._db.execute(f'DELETE FROM {kind.value} WHERE name = ?', (name,)).rowcount > 0

    def named(self, kind: NamedKind) -> Dict[str, Any]:
        """Returns all favourites or areas, by name."""
        return {name: json.loads(content) for name, content in
                self._db.execute(f'SELECT name, content FROM {kind.value} ORDER BY name')}

    # -- history ----------------------------------------------------------------------------------

    def add(self, now: float, robots: Mapping[str, Sums], edges: Mapping[int, float]) -> None:
        """Adds these values to the sums of the present hour."""
        hour = int(now // HOUR)
        self._db.execute('BEGIN')
        for name, sums in robots.items():
            self._db.execute('INSERT OR IGNORE INTO robot_hour VALUES (?, ?, 0, 0, 0, 0)',
                             (hour, name))
            self._db.execute(
                'UPDATE robot_hour SET distance = distance + ?, busy = busy + ?, '
                'waiting = waiting + ?, watched = watched + ? WHERE hour = ? AND robot = ?',
                (sums.distance, sums.busy, sums.waiting, sums.watched, hour, name))
        for edge, seconds in edges.items():
            self._db.execute('INSERT OR IGNORE INTO edge_hour VALUES (?, ?, 0)', (hour, edge))
            self._db.execute('UPDATE edge_hour SET waiting = waiting + ? '
                             'WHERE hour = ? AND edge = ?', (seconds, hour, edge))
        for table in ('robot_hour', 'edge_hour'):
            self._db.execute(f'DELETE FROM {table} WHERE hour < ?', (hour - KEPT_HOURS,))
        self._db.execute('COMMIT')

    def sums(self, since: float) -> HistorySums:
        """Returns the sums since the hour that contains the time `since` (s since 1970)."""
        return HistorySums(self.robot_sums(since), self.edge_waiting(since))

    def robot_sums(self, since: float) -> Dict[str, Sums]:
        """Returns the sums of each robot since the hour of the time `since` (s since 1970)."""
        rows = self._db.execute(
            'SELECT robot, SUM(distance), SUM(busy), SUM(waiting), SUM(watched) FROM robot_hour '
            'WHERE hour >= ? GROUP BY robot ORDER BY robot', (int(since // HOUR),))
        return {name: Sums(*numbers) for name, *numbers in rows}

    def edge_waiting(self, since: float) -> List[Tuple[int, float]]:
        """Returns the seconds that robots waited on each edge since the hour of `since`, the
        largest number first.
        """
        return list(self._db.execute(
            'SELECT edge, SUM(waiting) FROM edge_hour WHERE hour >= ? GROUP BY edge '
            'ORDER BY 2 DESC', (int(since // HOUR),)))

    # -- robots -----------------------------------------------------------------------------------

    def keep_charges(self, now: float, charges: Mapping[str, float]) -> None:
        """Keeps the charge of each battery (0..1), one value for each CHARGE_PERIOD."""
        period = int(now // CHARGE_PERIOD)
        self._db.execute('BEGIN')
        for name, charge in charges.items():
            self._db.execute('INSERT OR IGNORE INTO robot_charge VALUES (?, ?, ?)',
                             (name, period, round(charge, 3)))
        self._db.execute('DELETE FROM robot_charge WHERE period < ?',
                         (period - KEPT_CHARGE // CHARGE_PERIOD,))
        self._db.execute('COMMIT')

    def charges(self, robot: str) -> List[Tuple[int, float]]:
        """Returns the charges of a robot's battery with their times (s since 1970), the oldest
        first.
        """
        rows = self._db.execute('SELECT period, charge FROM robot_charge WHERE robot = ? '
                                'ORDER BY period', (robot,))
        return [(period * CHARGE_PERIOD, charge) for period, charge in rows]

    def note_events(self, events: Iterable[RobotEvent]) -> None:
        """Adds events of robots."""
        self._db.execute('BEGIN')
        for event in events:
            self._db.execute('INSERT INTO robot_event VALUES (NULL, ?, ?, ?, ?, ?, ?, ?, ?)',
                             astuple(event))
        self._db.execute('DELETE FROM robot_event WHERE id <= (SELECT MAX(id) FROM robot_event) '
                         '- ?', (KEPT_EVENTS,))
        self._db.execute('COMMIT')

    def events(self, robot: str, most: int) -> List[RobotEvent]:
        """Returns at most this number of events of a robot, the newest first."""
        rows = self._db.execute('SELECT time, robot, state, outage, works, alarm, waits_for, '
                                'mission FROM robot_event WHERE robot = ? ORDER BY id DESC LIMIT ?',
                                (robot, most))
        return [RobotEvent(time, name, state, outage, bool(works), *rest)
                for time, name, state, outage, works, *rest in rows]
