"""The journal: an SQLite file with all data that the supervisor needs after a restart.

All data are on the disk before they are published, and before a robot is sent an order that depends
on them: the supervisor stores once for each event, and then acts. The file also keeps the history
of each mission.
"""
from __future__ import annotations

import json
import sqlite3
import time
from dataclasses import astuple
from types import MappingProxyType
from typing import (
    Any,
    Callable,
    Dict,
    FrozenSet,
    Iterable,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Set,
    Tuple,
    Union,
)

from file_replacement import replace_file
from fleet_core.fleet import RobotType
from fleet_core.geometry.areas import Area
from fleet_core.interlocking.claims import ClaimsOf
from fleet_core.interlocking.reports import GraphPosition
from fleet_core.interlocking.route_master import Located, Lost, Memory
from fleet_core.supervision.fleet_stop import NOT_STOPPED, FleetStop
from fleet_core.supervision.journal_database import (
    JournalDatabase,
    JournalError,
    JournalUnavailable,
    UnknownLayout,
)
from fleet_core.supervision.mission_book import REMEMBERED
from fleet_core.supervision.missions import (
    DeadlineState,
    Mission,
    MissionState,
    Request,
    Status,
)
from fleet_core.supervision.outages import Outage
from fleet_core.work.work import RobotLoad, Work
from json_records import from_json, to_json
from route_protocol.master import MasterState, Step
from trajectory_graph import CurveType, Edge, Graph, Vertex

_LONGEST_NUMBER = 30  # maximum number of characters read from the file beside the journal
OPEN_STATES = f'({", ".join(str(int(state)) for state in MissionState if state.is_open)})'
"""The states of missions that have not ended, in SQL."""
_MISSION = 'serial, request, state, robot, reached, reason, deadline_state'


class RobotMemory(NamedTuple):
    """The stored state of one robot."""

    master: Memory
    outage: Optional[Outage]
    why: str
    is_halted: bool
    comes_to_rest: bool = False
    dock: Optional[int] = None
    charge: Optional[float] = None
    kind: Optional[RobotType] = None
    charge_until: float = 0.0
    tops_up: bool = False


# fields that later versions added to stops and steps
_ADDED_TO_WORK = ('group', 'device', 'load_type')
_NOTHING: Mapping[Any, Any] = MappingProxyType({})


class Journal:
    """The journal file, open for one supervisor. `clock` returns s since 1970.

    It has a method for each kind of record: no other class reads or writes the file.
    """

    def __init__(self, path: str, clock: Callable[[], float] = time.time) -> None:
        """Raises JournalUnavailable, or JournalError if the file can never be used."""
        self._clock = clock
        self._path = path
        self._beside = f'{path}.run'
        self._file = JournalDatabase(path)
        self._db = self._file.database
        try:
            self.graph(), self.robots(), self.missions(), self.stop(), self.works(), self.loads()
            self.claims()
        except (KeyError, ValueError, TypeError) as error:
            self.close()
            raise UnknownLayout(path, f'an entry cannot be read ({error!r})') from None
        except JournalError:
            self.close()
            raise

    def close(self) -> None:
        """Closes the file."""
        self._file.close()

    def milliseconds(self) -> int:
        """Returns ms since 1970, by the clock of the journal."""
        return int(1000.0 * self._clock())

    # -- writing ----------------------------------------------------------------------------------

    def store(self, missions: Iterable[Mission] = (),
              robots: Mapping[str, Optional[RobotMemory]] = _NOTHING,
              values: Mapping[str, int] = _NOTHING, graph: Optional[Graph] = None,
              stays: Mapping[int, float] = _NOTHING, stop: Optional[FleetStop] = None,
              works: Mapping[int, Optional[Work]] = _NOTHING,
              loads: Mapping[str, RobotLoad] = _NOTHING,
              claims: ClaimsOf = _NOTHING) -> None:
        """Stores all given data on the disk in one transaction.

        missions -- the missions that have changed
        robots   -- by name, the state of a robot; None: it has left the fleet for good
        values   -- numbers by name
        graph    -- the graph to which the robots' data refer
        stays    -- by the serial of a mission, how long ago (s) its robot began to stay where it is
        stop     -- whether the fleet is stopped; None: unchanged
        works    -- by the serial of a mission, the progress of its steps; None: it has ended
        loads    -- by name, what a robot carries
        claims   -- by name, all resources that a robot claims

        Raises JournalUnavailable; then nothing is stored.
        """
        with self._file.transaction():
            for mission in missions:
                self._write_mission(mission)
            for serial, seconds in stays.items():
                self._run('INSERT OR REPLACE INTO stay VALUES (?, ?)',
                          (serial, self._clock() - seconds))
            for name, memory in robots.items():
                self._set('robot', 'name', name, None if memory is None else _memory_text(memory))
            for serial, work in works.items():
                self._set('work', 'serial', serial,
                          None if work is None else json.dumps(to_json(work)))
            for name, load in loads.items():
                self._run('INSERT OR REPLACE INTO load VALUES (?, ?)',
                          (name, json.dumps(to_json(load))))
            for name, resources in claims.items():
                self._run('DELETE FROM claim WHERE robot = ?', (name,))
                for resource in sorted(resources):
                    self._run('INSERT INTO claim VALUES (?, ?)', (name, resource))
            if graph is not None:
                self._run('INSERT OR REPLACE INTO graph VALUES (1, ?)', (_graph_text(graph),))
            for name, number in values.items():
                self._run('INSERT OR REPLACE INTO value VALUES (?, ?)', (name, number))
            if stop is not None:
                self._run('INSERT OR REPLACE INTO stop VALUES (1, ?)', (json.dumps(to_json(stop)),))

    def _set(self, table: str, column: str, key: Union[int, str], text: Optional[str]) -> None:
        """Stores the text of a key, or deletes the key if there is no text."""
        if text is None:
            self._run(f'DELETE FROM {table} WHERE {column} = ?', (key,))
        else:
            self._run(f'INSERT OR REPLACE INTO {table} VALUES (?, ?)', (key, text))

    def _write_mission(self, mission: Mission) -> None:
        """Stores the mission as it is now, and the change in the history."""
        now = (int(mission.state), mission.robot, mission.reached, mission.reason)
        request, moment = mission.request, self._clock()
        self._run('INSERT OR REPLACE INTO mission VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)',
                  (mission.serial, request.id, _request_text(request), *now, request.stamp, moment,
                   int(mission.deadline_state)))
        self._run('INSERT INTO change VALUES (?, ?, ?, ?, ?, ?, ?)',
                  (moment, mission.serial, *now, mission.changed_by))
        if mission.stays_since is None or not mission.state.is_open:
            self._run('DELETE FROM stay WHERE serial = ?', (mission.serial,))

    def forget(self, age: float, most: int = 200) -> int:
        """Deletes at most `most` missions that ended more than `age` s ago. Returns their number.

        The last mission is kept, so that no serial is used twice. Raises JournalUnavailable.
        """
        serials = [row[0] for row in self._run(
            f'SELECT serial FROM mission WHERE changed < ? AND state NOT IN {OPEN_STATES} '
            'AND serial < (SELECT MAX(serial) FROM mission) ORDER BY changed LIMIT ?',
            (self._clock() - age, most))]
        if serials:
            with self._file.transaction():
                for table in ('change', 'mission'):
                    for serial in serials:
                        self._run(f'DELETE FROM {table} WHERE serial = ?', (serial,))
        return len(serials)

    def _run(self, statement: str, values: Tuple[object, ...] = ()) -> sqlite3.Cursor:
        try:
            return self._db.execute(statement, values)
        except sqlite3.Error as error:
            raise JournalUnavailable(self._path, error) from None

    def write_beside(self, number: int) -> None:
        """Writes a number into the file beside the journal. Raises JournalUnavailable."""
        try:
            replace_file(self._beside, f'{number}\n')
        except OSError as error:
            raise JournalUnavailable(self._beside, error) from None

    # -- reading ----------------------------------------------------------------------------------

    def value(self, name: str) -> int:
        """Returns a stored number; 0: there is none."""
        row = self._run('SELECT number FROM value WHERE name = ?', (name,)).fetchone()
        return int(row[0]) if row else 0

    def stop(self) -> FleetStop:
        """Returns whether the fleet is stopped, with author, time and reason."""
        row = self._run('SELECT record FROM stop').fetchone()
        return from_json(FleetStop, json.loads(row[0])) if row else NOT_STOPPED

    def number_beside(self) -> int:
        """Returns the number in the file beside the journal; 0: there is none.

        -1: it cannot be read.
        """
        try:
            with open(self._beside, encoding='ascii') as file:
                return int(file.read(_LONGEST_NUMBER))
        except FileNotFoundError:
            return 0
        except (OSError, ValueError):
            return -1

    def graph(self) -> Optional[Graph]:
        """Returns the graph to which the stored data of robots refer; None: there is none."""
        row = self._run('SELECT elements FROM graph').fetchone()
        return _graph(row[0]) if row else None

    def missions(self) -> List[Mission]:
        """Returns the open missions and the last ended ones, in the order of their acceptance."""
        rows = self._run(
            f'SELECT * FROM (SELECT {_MISSION} FROM mission WHERE state IN {OPEN_STATES} UNION '
            f'SELECT * FROM (SELECT {_MISSION} FROM mission WHERE state NOT IN {OPEN_STATES} '
            'ORDER BY serial DESC LIMIT ?)) ORDER BY serial', (REMEMBERED,))
        return [_mission(row) for row in rows]

    def stays(self) -> Dict[int, float]:
        """Returns, by serial, how long (s) each mission has stayed where it is; at least 0."""
        now = self._clock()
        return {int(serial): max(now - began, 0.0)
                for serial, began in self._run('SELECT serial, began FROM stay')}

    def works(self) -> Dict[int, Work]:
        """Returns, by serial, the progress of the steps of each open mission that has steps."""
        return {int(serial): from_json(Work, json.loads(text), added=_ADDED_TO_WORK)
                for serial, text in self._run('SELECT serial, work FROM work')}

    def loads(self) -> Dict[str, RobotLoad]:
        """Returns, by name, what each robot carries. A robot that never had a load has no entry."""
        return {name: from_json(RobotLoad, json.loads(text), added=('types',))
                for name, text in self._run('SELECT robot, load FROM load')}

    def claims(self) -> Dict[str, FrozenSet[str]]:
        """Returns, by name, the resources that each robot claims.

        A robot without claims has no entry.
        """
        found: Dict[str, Set[str]] = {}
        for name, resource in self._run('SELECT robot, resource FROM claim'):
            found.setdefault(name, set()).add(resource)
        return {name: frozenset(resources) for name, resources in found.items()}

    def find(self, request: Request) -> Optional[Mission]:
        """Returns the last mission made from exactly this request, however long ago it ended.

        Raises JournalUnavailable.
        """
        rows = self._run(
            f'SELECT {_MISSION} FROM mission '
            'WHERE request_id = ? AND stamp = ? ORDER BY serial DESC', (request.id, request.stamp))
        return next((mission for mission in map(_mission, rows)
                     if mission.request.identity == request.identity), None)

    def status(self, request_id: int, stamp: float) -> Optional[Status]:
        """Returns the stored status of the last mission with this id and stamp; stamp 0 means any
        stamp.

        Raises JournalUnavailable.
        """
        row = self._run(
            f'SELECT {_MISSION} FROM mission WHERE '
            'request_id = ? AND (? = 0.0 OR stamp = ?) ORDER BY serial DESC LIMIT 1',
            (request_id, stamp, stamp)).fetchone()
        return None if row is None else _mission(row).status

    def last_serial(self) -> int:
        """Returns the serial of the last mission that was accepted; 0: there was none."""
        return int(self._run('SELECT MAX(serial) FROM mission').fetchone()[0] or 0)

    def robots(self) -> Dict[str, RobotMemory]:
        """Returns the stored state of each robot."""
        return {name: _memory(text) for name, text in self._run('SELECT name, memory FROM robot')}



def _request_text(request: Request) -> str:
    return json.dumps(to_json(request))


def _mission(row: Tuple[int, str, int, str, int, str, int]) -> Mission:
    """Returns the mission that a row stores. The row has the columns of _MISSION."""
    serial, text, state, robot, reached, reason, deadline = row
    return Mission(serial, read_request(text), MissionState(state), robot, reached, reason=reason,
                   deadline_state=DeadlineState(deadline))


def read_request(text: str) -> Request:
    """Reads a request. Version 0.2 stored a list, in the order of the fields of that version."""
    stored = json.loads(text)
    values: Dict[str, Any] = stored if isinstance(stored, dict) else dict(zip(
        ('id', 'destinations', 'robot_type', 'robot', 'priority', 'dwells', 'stamp'), stored))
    return from_json(Request, values, added=(
        'requested_by', 'stops', 'on_cancel', 'after', 'template', 'arguments', 'earliest',
        'deadline', *_ADDED_TO_WORK))


def _graph_text(graph: Graph) -> str:
    return json.dumps([[astuple(vertex) for vertex in graph.vertices.values()],
                       [[*astuple(edge)[:3], edge.curve_type.value, *astuple(edge)[4:]]
                        for edge in graph.edges.values()]])


def _graph(text: str) -> Graph:
    vertices, edges = json.loads(text)
    return Graph((Vertex(*values) for values in vertices),
                 (Edge(id, origin, destination, CurveType(curve), *numbers)
                  for id, origin, destination, curve, *numbers in edges))


def _position_values(position: Optional[GraphPosition]) -> Optional[Tuple[Any, ...]]:
    return None if position is None else astuple(position)


def _position(values: Optional[Sequence[Any]]) -> Optional[GraphPosition]:
    return None if values is None else GraphPosition(*values)


def _memory_text(memory: RobotMemory) -> str:
    master, kind = memory.master, memory.kind
    return json.dumps({
        'protocol': to_json(master.protocol),
        'cleared': master.cleared, 'place': _position_values(master.position),
        'locations': to_json(master.locations),
        'lost': [[area.line, area.radius] for area in master.lost.areas],
        'lost_until': master.lost.until, 'absent': master.is_absent,
        'outage': None if memory.outage is None else memory.outage.name, 'why': memory.why,
        'halted': memory.is_halted, 'resting': memory.comes_to_rest,
        'dock': memory.dock, 'charge': memory.charge, 'charge_until': memory.charge_until,
        'tops_up': memory.tops_up,
        'type': None if kind is None else [kind.name, kind.radius, kind.fastest, kind.play]})


def _memory(text: str) -> RobotMemory:
    stored: Dict[str, Any] = json.loads(text)
    master = _of_version_1(stored) if 'track' in stored else Memory(
        from_json(MasterState, stored['protocol']), tuple(stored['cleared']),
        _position(stored['place']),
        tuple(from_json(Located, location) for location in stored['locations']),
        Lost(_areas(stored['lost']), stored['lost_until']), stored['absent'])
    outage, kind = stored['outage'], stored.get('type')
    return RobotMemory(master, None if outage is None else Outage[outage], stored['why'],
                       stored['halted'], stored.get('resting', False), stored.get('dock'),
                       stored.get('charge'), None if kind is None else RobotType(*kind),
                       stored.get('charge_until', 0.0), stored.get('tops_up', False))


def _areas(stored: Iterable[Sequence[Any]]) -> Tuple[Area, ...]:
    return tuple(Area(tuple((x, y) for x, y in line), radius) for line, radius in stored)


def _of_version_1(stored: Dict[str, Any]) -> Memory:
    """Reads an entry of version 1.0 or earlier, which has no order numbers.

    The robot holds all edges of the entry until it has obeyed a stop and stands.
    """
    outliers, lost, foreign, reach, location, is_absent, *_ = stored.get('evidence') or (
        (), (), (), 0.0, None, False)
    begin, fraction = stored.get('cleared', (0, 0.0))
    edges = (*stored['track'][begin:], *stored.get('tail', ()), *foreign)
    held = tuple(Step(number, edge) for number, edge in enumerate(edges))
    locations = [Located((point[0], point[1]), age) for point, age in outliers]
    if location is not None and reach:
        locations.append(Located((location[0], location[1])))
    return Memory(MasterState(held=held, is_anywhere=bool(reach)), (0, fraction),
                  _position(stored['place']), tuple(locations[:2]), Lost(_areas(lost)),
                  is_absent=is_absent)
