"""The journal: whole transactions, files of older versions, refusal of a second process, the file
itself, and its growth.
"""
from __future__ import annotations

import json
import math
import os
import resource
import shutil
import sqlite3
import subprocess
import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from fleet_builders import AGV, corridor

from fleet_core.geometry.areas import Area
from fleet_core.interlocking.reports import GraphPosition
from fleet_core.interlocking.route_master import Located, Lost, Memory
from fleet_core.supervision.fleet_stop import FleetStop, StopCause
from fleet_core.supervision.history import history
from fleet_core.supervision.journal import Journal, RobotMemory
from fleet_core.supervision.journal_database import (
    JournalError,
    JournalUnavailable,
    NoJournal,
    UnknownLayout,
)
from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.missions import (
    Acceptance,
    DeadlineState,
    Mission,
    MissionState,
    Request,
)
from fleet_core.supervision.outages import Outage
from fleet_core.work.rules import begin
from fleet_core.work.stops import Condition, LoadEffect, WorkStep, WorkStop
from fleet_core.work.tables import LoadState
from fleet_core.work.work import RobotLoad, Situation, StepPlace, work_of
from route_protocol.master import MasterState, Order, Step
from world.supervised_fleet import SupervisedFleet, blocked

ACCEPTANCE = Acceptance(corridor(5), {'a': AGV, 'b': AGV})
DAY = 86400.0
TABLES_0_2 = '''
CREATE TABLE mission (
    serial INTEGER PRIMARY KEY, request_id INTEGER NOT NULL, request TEXT NOT NULL,
    state INTEGER NOT NULL, robot TEXT NOT NULL, reached INTEGER NOT NULL, reason TEXT NOT NULL);
CREATE INDEX mission_by_id ON mission (request_id);
CREATE INDEX mission_by_state ON mission (state);
CREATE TABLE change (
    time REAL NOT NULL, serial INTEGER NOT NULL, state INTEGER NOT NULL, robot TEXT NOT NULL,
    reached INTEGER NOT NULL, reason TEXT NOT NULL);
CREATE INDEX change_by_serial ON change (serial);
CREATE TABLE robot (name TEXT PRIMARY KEY, memory TEXT NOT NULL);
CREATE TABLE value (name TEXT PRIMARY KEY, number INTEGER NOT NULL);
'''
REQUEST = Request(7, (2, 3), 'agv', 'a', 4, (1.0, -1.0), 9.5)
OLD_MEMORY = {'route_id': 5, 'track': [1, -2], 'done': 1, 'bases': [[5, 0]], 'over': False,
              'ended': [4], 'stopping': False, 'shortened': None, 'place': [None, 1, 0.25],
              'outage': None, 'why': '', 'halted': False, 'resting': False, 'dock': None,
              'charge': 0.5}
# as version 1.0.0 wrote it: the robot drives on edge 3, has just left edge 2, may not have received
# edge 5, and was once seen beside its path
MEMORY_1_0 = {
    'route_id': 40, 'track': [1, 2, 3, 4], 'done': 2, 'bases': [[40, 0, 3]], 'over': False,
    'ended': [39], 'stopping': False, 'shortened': None, 'place': [2, 0, 0.0],
    'cleared': [1, 0.5], 'tail': [5],
    'evidence': [[[[1.0, 3.0], 0.5]], [[[[20.0, 3.0], [20.0, 4.0]], 0.0]], [], 0.0, None, False,
                 False],
    'stamp': 12.5, 'withdrawn': None, 'acknowledged': [40], 'outage': None, 'why': '',
    'halted': False, 'resting': False, 'dock': 6, 'charge': 0.5, 'type': ['agv', 0.4, 1.0, 0.0]}


class Clock:
    """Seconds since 1970, as the test sets them."""

    now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def path(tmp_path) -> str:
    return str(tmp_path / 'fleet.sqlite')


def test_the_journal_gives_back_what_was_committed(tmp_path):
    path = str(tmp_path / 'fleet.sqlite')
    journal = Journal(path, clock=lambda: 1000.0)
    book = MissionBook()
    mission = book.add(Request(7, (2, 3), 'agv', 'a', 4, (1.0, -1.0), 9.5), ACCEPTANCE)
    book.set(mission, MissionState.ACTIVE, robot='a')
    protocol = MasterState(
        epoch=2 ** 60, report=12, number=9, order=7, refused=8, done=1,
        open=(Order(7, 2 ** 60, 0, (1, -2), 3), Order(9, 0, 1, ())), behind=(Step(0, 1),),
        held=(Step(1, 4),), is_anywhere=True, commands=True, unknown=9, gap=(5, 6))
    master = Memory(protocol, (1, 0.5), GraphPosition(edge=1, fraction=0.25),
                    (Located((1.0, 2.0), 0.5),), Lost((Area(((0.0, 0.0), (1.0, 0.0)), 0.3),), 9),
                    True)
    memory = RobotMemory(master, Outage.TAKEN_OVER, 'why', True, True, 6, 0.5, AGV)
    journal.store([mission], {'a': memory}, {'number': 7})
    journal.close()

    again = Journal(path)
    stored, = again.missions()
    assert (stored.request, stored.state, stored.robot, stored.reached) == (
        mission.request, MissionState.ACTIVE, 'a', 0)
    assert again.robots() == {'a': memory}
    assert again.value('number') == 7
    assert again.last_serial() == 1
    line, = history(path)
    assert (line.request_id, line.accepted, line.started, line.ended) == (7, 1000.0, 1000.0, None)


def test_a_journal_is_safe_against_power_loss(tmp_path):
    journal = Journal(str(tmp_path / 'fleet.sqlite'))
    assert journal._db.execute('PRAGMA journal_mode').fetchone() == ('wal',)
    assert journal._db.execute('PRAGMA synchronous').fetchone() == (2,)  # FULL


def test_files_that_are_no_journals_are_named(tmp_path):
    path = tmp_path / 'notes.txt'
    path.write_text('no database, but long enough to be looked at closely by SQLite' * 20)
    for use in (Journal, lambda path: list(history(path))):
        with pytest.raises(JournalError, match='notes.txt'):
            use(str(path))
    with pytest.raises(NoJournal, match='There is no journal'):
        list(history(str(tmp_path / 'none.sqlite')))


@contextmanager
def full_disk():
    """Makes it impossible for this process to extend any file."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


def test_on_a_full_disk_all_of_it_is_stored_or_nothing(tmp_path):
    path = str(tmp_path / 'fleet.sqlite')
    journal = Journal(path)
    many = {f'{k}' * 100: k for k in range(1000)}
    with full_disk(), pytest.raises(JournalUnavailable, match='fleet.sqlite cannot be written'):
        journal.store(values={'first': 1, **many})
    assert journal.value('first') == 0
    journal.store(values={'second': 2})
    journal.close()
    again = Journal(path)
    assert (again.value('first'), again.value('second')) == (0, 2)


def test_a_file_that_another_program_holds_is_waited_for_only_shortly(tmp_path):
    path = str(tmp_path / 'fleet.sqlite')
    journal, other = Journal(path), sqlite3.connect(path, isolation_level=None)
    other.execute('BEGIN IMMEDIATE')
    begun = time.monotonic()
    with pytest.raises(JournalUnavailable, match='locked'):
        journal.store(values={'first': 1})
    assert time.monotonic() - begun < 5.0
    other.execute('ROLLBACK')
    journal.store(values={'first': 1})


def write_0_2(path: str) -> None:
    """Writes a file as version 0.2 did, with an open mission and a robot."""
    db = sqlite3.connect(path)
    db.executescript(TABLES_0_2)
    text = json.dumps([7, [2, 3], 'agv', 'a', 4, [1.0, -1.0], 9.5])
    db.execute('INSERT INTO mission VALUES (3, 7, ?, 1, ?, 0, ?)', (text, 'a', ''))
    db.execute('INSERT INTO change VALUES (500.0, 3, 1, ?, 0, ?)', ('a', ''))
    db.execute('INSERT INTO robot VALUES (?, ?)', ('a', json.dumps(OLD_MEMORY)))
    db.execute('INSERT INTO value VALUES (?, ?)', ('route_id', 40))
    db.commit()
    db.close()


def ended(serial: int, request: Request = REQUEST) -> Mission:
    book = MissionBook(next_serial=serial)
    mission = book.add(replace(request, id=serial), ACCEPTANCE)
    book.set(mission, MissionState.ACTIVE, robot='a')
    book.set(mission, MissionState.SUCCEEDED)
    return mission


def test_a_file_of_version_0_2_is_migrated_and_loses_nothing(path):
    write_0_2(path)
    journal = Journal(path)
    mission, = journal.missions()
    assert (mission.serial, mission.request, mission.state) == (3, REQUEST, MissionState.ACTIVE)
    assert journal.find(REQUEST).serial == 3
    assert journal.robots()['a'].master.held == (1, -2)
    assert (journal.value('route_id'), journal.last_serial()) == (40, 3)
    line, = history(path)
    assert (line.request_id, line.accepted) == (7, 500.0)
    journal.close()
    Journal(path).close()  # the second time there is nothing to migrate


def write_1_0(path: str, memory: dict) -> None:
    """Replaces the entry of a robot in the journal by an entry as version 1.0.0 wrote it."""
    db = sqlite3.connect(path)
    db.execute('INSERT OR REPLACE INTO robot VALUES (?, ?)', ('a', json.dumps(memory)))
    db.commit()
    db.close()


def test_a_file_of_version_1_0_is_migrated_with_its_open_mission(path):
    """Version 1.0.0 wrote version 3 of the file, and requests without stops."""
    journal = Journal(path)
    journal.store([Mission(3, REQUEST, MissionState.ACTIVE, 'a')])
    journal.close()
    db = sqlite3.connect(path)
    text, = db.execute('SELECT request FROM mission').fetchone()
    old = {key: value for key, value in json.loads(text).items()
           if key in ('id', 'destinations', 'robot_type', 'robot', 'priority', 'dwells', 'stamp',
                      'requested_by')}
    db.execute('UPDATE mission SET request = ?', (json.dumps(old),))
    db.executescript('DROP TABLE stop; DROP TABLE work; DROP TABLE load; DROP TABLE claim; '
                     'ALTER TABLE mission DROP COLUMN deadline_state; PRAGMA user_version = 3')
    db.close()
    journal = Journal(path)
    mission, = journal.missions()
    assert (mission.request, mission.state) == (REQUEST, MissionState.ACTIVE)
    assert journal.works() == journal.loads() == journal.claims() == {}


def test_a_file_without_claims_is_migrated_and_loses_nothing(path):
    """The file has version 5, which no release has written."""
    journal = Journal(path)
    journal.store([Mission(3, REQUEST, MissionState.ACTIVE, 'a')], loads={'a': RobotLoad()})
    journal.close()
    db = sqlite3.connect(path)
    db.executescript('DROP TABLE claim; ALTER TABLE mission DROP COLUMN deadline_state; '
                     'PRAGMA user_version = 5')
    db.close()
    journal = Journal(path)
    assert journal.claims() == {} and journal.loads() == {'a': RobotLoad()}
    assert [mission.serial for mission in journal.missions()] == [3]


def test_claims_come_back(path):
    journal = Journal(path)
    journal.store(claims={'a': frozenset({'gate', 'press'}), 'b': frozenset({'gate'})})
    journal.store(claims={'a': frozenset({'press'}), 'b': frozenset()})
    journal.close()
    journal = Journal(path)
    assert journal.claims() == {'a': {'press'}}


def write_file_1_0(path: str) -> None:
    """Writes a journal of version 1.0.0, from the dump of a file that version 1.0.0 wrote."""
    db = sqlite3.connect(path)
    db.executescript((Path(__file__).parent / 'journal_1_0_0.sql').read_text(encoding='utf-8'))
    db.close()


def test_a_file_that_version_1_0_wrote_loses_nothing(path):
    write_file_1_0(path)
    journal = Journal(path)
    assert [(mission.request.id, mission.request.destinations, mission.state, mission.robot)
            for mission in journal.missions()] == [
        (7, (4, 6), MissionState.ACTIVE, 'a'), (8, (8,), MissionState.SUCCEEDED, 'b')]
    a, b = (journal.robots()[name] for name in 'ab')
    assert a.master.held == (2,) and a.master.position == GraphPosition(vertex=2)
    assert (b.master.held, b.master.position) == ((), GraphPosition(vertex=8))
    assert (a.outage, b.outage) == (None, Outage.OUT_OF_SERVICE)
    assert set(journal.graph().edges) == set(range(1, 8))
    assert [(line.request_id, line.state) for line in history(path)] == [
        (7, MissionState.ACTIVE), (8, MissionState.SUCCEEDED)]


def test_a_fleet_of_version_1_0_stops_once_is_located_and_goes_on():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 2), 'b': (AGV, 8)})
    fleet.disk.replace_file(write_file_1_0)
    fleet.agvs['a'].edge, fleet.agvs['a'].arc = 2, 1.4
    fleet.restart()
    assert blocked(fleet, 'a')[1] == (2,)
    fleet.run_until_done(7)
    assert fleet.state(7) is MissionState.SUCCEEDED
    orders = [one.order for one in fleet.sent if one.robot == 'a']
    assert not orders[0].edges
    assert {one.number for one in orders if not one.edges} == {orders[0].number}
    assert fleet.supervisor.robots['b'].outage is Outage.OUT_OF_SERVICE


def test_a_file_without_deadlines_is_migrated_with_its_steps(path):
    """Version 5 of the file has stops and steps, but no templates and no deadlines."""
    stops = (WorkStop(2, steps=(WorkStep('take', 5.0),)), WorkStop(3))
    request = replace(REQUEST, stops=stops)
    journal = Journal(path)
    journal.store([Mission(3, request, MissionState.ACTIVE, 'a')], works={3: work_of(stops)})
    journal.close()
    db = sqlite3.connect(path)
    text, = db.execute('SELECT request FROM mission').fetchone()
    old = {key: value for key, value in json.loads(text).items()
           if key not in ('template', 'arguments', 'earliest', 'deadline')}
    assert len(old) == len(json.loads(text)) - 4
    db.execute('UPDATE mission SET request = ?', (json.dumps(old),))
    db.executescript('ALTER TABLE mission DROP COLUMN deadline_state; PRAGMA user_version = 6')
    db.close()
    journal = Journal(path)
    mission, = journal.missions()
    assert (mission.request, mission.deadline_state) == (request, DeadlineState.NONE)
    assert journal.works() == {3: work_of(stops)}
    assert journal.find(request).serial == 3


def test_a_template_and_the_times_of_a_mission_come_back(path):
    request = replace(REQUEST, template='pallet', arguments=(('from', 'press'),), earliest=5.0,
                      deadline=9.5)
    journal = Journal(path)
    journal.store([Mission(3, request, MissionState.PLANNED,
                           deadline_state=DeadlineState.AT_RISK)])
    journal.close()
    mission, = Journal(path).missions()
    assert (mission.request, mission.state, mission.deadline_state) == (
        request, MissionState.PLANNED, DeadlineState.AT_RISK)


def test_a_file_without_types_of_load_is_read_and_its_loads_may_be_anything(path):
    stops = (WorkStop(2, steps=(WorkStep('take', 5.0, load=LoadEffect.TAKES),)), WorkStop(3))
    loads = {'a': RobotLoad(LoadState.LOADED, 3, 1), 'b': RobotLoad(LoadState.UNKNOWN, 3),
             'c': RobotLoad()}
    journal = Journal(path)
    journal.store([Mission(3, replace(REQUEST, stops=stops), MissionState.ACTIVE, 'a')],
                  works={3: work_of(stops)}, loads=loads)
    journal.close()
    db = sqlite3.connect(path)
    for table, column in (('mission', 'request'), ('work', 'work'), ('load', 'load')):
        for number, text in db.execute(f'SELECT rowid, {column} FROM {table}').fetchall():
            old = text.replace(', "load_type": ""', '').replace(', "types": null', '')
            assert old != text
            db.execute(f'UPDATE {table} SET {column} = ? WHERE rowid = ?', (old, number))
    db.commit()
    db.close()
    journal = Journal(path)
    assert journal.missions()[0].request.stops == stops and journal.works() == {3: work_of(stops)}
    assert journal.loads() == loads
    assert [journal.loads()[name].may_be for name in 'abc'] == [{''}, {''}, set()]


def test_steps_and_loads_come_back(path):
    step = WorkStep('take', 5.0, (('where', 'left'),), load=LoadEffect.TAKES, load_type='pallet')
    stops = (WorkStop(2, steps=(step,)), WorkStop(3))
    begun = begin(Situation(3, work_of(stops, (WorkStop(1, condition=Condition.LOADED),))),
                  StepPlace(0, 0), 2 ** 60, 2 ** 61, 10 ** 12)
    request = replace(REQUEST, stops=stops)
    journal = Journal(path)
    journal.store([Mission(3, request)], works={3: begun.work}, loads={'a': begun.load})
    journal.close()
    journal = Journal(path)
    assert (journal.works(), journal.loads()) == ({3: begun.work}, {'a': begun.load})
    assert journal.loads()['a'].may_be == {'pallet'}
    assert journal.missions()[0].request == request
    journal.store(works={3: None})
    assert journal.works() == {}


def test_a_robot_of_version_1_0_keeps_all_that_it_may_be_on(path):
    Journal(path).close()
    write_1_0(path, MEMORY_1_0)
    robot = Journal(path).robots()['a']
    master = robot.master
    assert master.held == (2, 3, 4, 5) and master.cleared == (0, 0.5)
    assert master.position == GraphPosition(vertex=2)
    assert master.locations == (Located((1.0, 3.0), 0.5),)
    assert master.lost.areas == (Area(((20.0, 3.0), (20.0, 4.0))),)
    assert not (master.is_absent or master.protocol.open or master.protocol.is_ready)
    assert (robot.dock, robot.charge, robot.kind) == (6, 0.5, AGV)


def test_a_robot_of_version_1_0_that_another_one_moved_may_still_be_moved(path):
    Journal(path).close()
    evidence = [[], [], [4], 3.0, [1.0, 2.0], False, True]
    write_1_0(path, {**MEMORY_1_0, 'track': [], 'tail': [], 'evidence': evidence})
    master = Journal(path).robots()['a'].master
    assert master.protocol.is_anywhere and master.locations == (Located((1.0, 2.0)),)
    assert master.held == (4,), 'a route of another giver is held as well'


def test_edges_of_version_1_0_are_held_until_the_robot_was_stopped_and_stands():
    """The robot's programs were also replaced: it has no route any more, but may still be coming to
    rest.
    """
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 2)})
    fleet.run(1.0)
    write_1_0(fleet.disk.journal._path, {**MEMORY_1_0, 'evidence': None})
    fleet.agvs['a'].obey_another((2, 3))
    fleet.network.silent['a'] = fleet.now + 2.0
    fleet.restart()
    assert blocked(fleet, 'a')[1] == (2, 3, 4, 5)
    fleet.run(2.5)
    assert fleet.agvs['a'].is_driving and {2, 3, 4, 5} <= set(blocked(fleet, 'a')[1])
    before = len(fleet.sent)
    fleet.request(1, 6)
    fleet.run_until(lambda: not fleet.agvs['a'].is_driving)
    assert not [order for order in fleet.sent[before:] if order.edges]
    fleet.run(1.0)
    assert fleet.sent[before].edges == () and not {2, 5} & set(blocked(fleet, 'a')[1])
    assert fleet.supervisor.robots['a'].master.is_ready


def test_each_change_keeps_who_requested_it(path):
    journal, book = Journal(path), MissionBook()
    mission = book.add(replace(REQUEST, requested_by='anna (page)'), ACCEPTANCE)
    journal.store(book.changes)
    book.stored()
    for state, person in ((MissionState.ACTIVE, ''), (MissionState.CANCELLED, 'boris (page)')):
        book.set(mission, state)
        mission.changed_by = person
        journal.store(book.changes)
    rows = sqlite3.connect(path).execute('SELECT requested_by FROM change ORDER BY rowid')
    assert [row[0] for row in rows] == ['anna (page)', '', 'boris (page)']
    line, = history(path)
    assert line.requested_by == 'anna (page)'
    assert journal.missions()[0].request.requested_by == 'anna (page)'
    journal.close()


def test_a_stop_of_a_version_without_records_still_holds(path):
    write_0_2(path)
    database = sqlite3.connect(path)
    database.execute("INSERT INTO value VALUES ('fleet_is_stopped', 1)")
    database.commit()
    database.close()
    for _ in range(2):
        journal = Journal(path)
        assert journal.stop() == FleetStop(StopCause.UNKNOWN)
        journal.close()


@pytest.mark.parametrize('change, says', [
    ('ALTER TABLE mission ADD COLUMN colour TEXT', 'colour'),
    ('PRAGMA user_version = 99', 'version 99'),
    ("UPDATE robot SET memory = '{}'", 'cannot be read'),
    ("UPDATE mission SET state = 77", 'cannot be read'),
    ("INSERT INTO stop VALUES (1, '{}')", 'cannot be read')])
def test_a_file_of_an_unknown_layout_is_refused_in_one_sentence(path, change, says):
    write_0_2(path)
    Journal(path).close()
    db = sqlite3.connect(path)
    db.execute(change)
    db.commit()
    db.close()
    with pytest.raises(UnknownLayout, match='fleet.sqlite cannot be used') as refused:
        Journal(path)
    assert says in str(refused.value) or says == 'cannot be read'


def test_a_second_supervisor_on_the_file_is_refused_until_the_first_has_ended(path):
    first = Journal(path)
    with pytest.raises(JournalUnavailable, match='another path_supervisor uses it'):
        Journal(path)
    first.store(values={'number': 1})
    first.close()
    assert Journal(path).value('number') == 1


def remove(path: str) -> None:
    os.remove(path)


def replace_by_another(path: str) -> None:
    Journal(path + '.other').close()
    os.replace(path + '.other', path)


def remove_the_log(path: str) -> None:
    os.remove(path + '-wal')


def overwrite(path: str) -> None:
    other = Journal(path + '.other')
    for number in range(5):
        other.store(values={'number': number})
    other.close()
    shutil.copyfile(path + '.other', path)


@pytest.mark.parametrize('do', [remove, replace_by_another, remove_the_log, overwrite])
def test_a_file_that_is_not_the_one_that_was_opened_is_noticed_before_a_commit(path, do):
    journal = Journal(path)
    for number in range(3):
        journal.store(values={'number': number})
    do(path)
    for _ in range(2):
        with pytest.raises(JournalUnavailable, match='put the file back'):
            journal.store(values={'number': 9})


def test_commits_and_checkpoints_of_its_own_are_no_foreign_changes(path):
    journal = Journal(path)
    journal._db.execute('PRAGMA wal_autocheckpoint = 2')  # pages
    for number in range(30):
        journal.store(values={f'{number}' * 200: number})
    assert len(list(history(path))) == 0
    journal.store(values={'last': 1})


def test_missions_are_forgotten_when_they_ended_long_ago_but_never_open_ones(path):
    clock = Clock()
    journal = Journal(path, clock)
    open_mission = MissionBook().add(replace(REQUEST, id=1), ACCEPTANCE)
    journal.store([open_mission])
    journal.store([ended(serial) for serial in (2, 3, 4)])
    clock.now += 91 * DAY
    journal.store([ended(serial) for serial in (5, 6)])
    assert journal.forget(90 * DAY, most=2) == 2, 'only a little may be deleted at a time'
    assert journal.forget(90 * DAY) == 1
    assert [line.request_id for line in history(path)] == [1, 5, 6]
    clock.now += 91 * DAY
    journal.forget(90 * DAY)
    assert journal.last_serial() == 6, 'no serial may be given twice'
    assert [line.request_id for line in history(path)] == [1, 6]


def test_what_cannot_be_forgotten_leaves_no_transaction_open(path):
    clock = Clock()
    journal = Journal(path, clock)
    journal.store([ended(serial) for serial in range(1, 300)])
    clock.now += 91 * DAY
    with full_disk(), pytest.raises(JournalUnavailable):
        journal.forget(90 * DAY)
    journal.store(values={'number': 1})
    assert journal.value('number') == 1 and len(list(history(path))) == 299


def test_the_history_is_read_page_by_page(path, monkeypatch):
    monkeypatch.setattr('fleet_core.supervision.history._PAGE', 4)
    journal = Journal(path)
    journal.store([ended(serial) for serial in range(1, 10)])
    assert [line.request_id for line in history(path)] == list(range(1, 10))


def test_a_resent_request_is_found_by_its_fields(path):
    journal = Journal(path)
    journal.store([ended(1, replace(REQUEST, stamp=1.0))])
    sent = replace(REQUEST, id=1, stamp=1.0)
    assert journal.find(sent).request.identity == sent.identity
    assert journal.find(replace(sent, stamp=2.0)) is None
    assert journal.find(replace(sent, robot='b')) is None
    assert journal.find(replace(sent, destinations=(3,), priority=9)), (
        'the request may differ because of MODIFY')



def test_the_history_since_a_time_has_what_changed_and_what_is_open(path):
    clock = Clock()
    journal = Journal(path, clock)
    journal.store([MissionBook().add(replace(REQUEST, id=1), ACCEPTANCE), ended(2)])
    clock.now += 50.0
    journal.store([ended(3)])
    assert [line.request_id for line in history(path, clock.now)] == [1, 3]
    assert [line.request_id for line in history(path, math.inf)] == [1]


@pytest.mark.parametrize('runs', [True, False])
def test_the_history_is_read_where_nothing_may_be_written(on_small_disk, runs):
    """The page reads the journal without writing, whether the fleet manager runs or not."""
    def read(disk):
        own, shown = disk.folder / 'own', disk.folder / 'shown'
        own.mkdir()
        shown.mkdir()
        journal = Journal(str(own / 'fleet.sqlite'))
        journal.store([ended(1)])
        if not runs:
            journal.close()
        subprocess.run(['mount', '--bind', str(own), str(shown)], check=True)
        subprocess.run(['mount', '-o', 'remount,bind,ro', str(shown)], check=True)
        try:
            return [line.request_id for line in history(str(shown / 'fleet.sqlite'))]
        finally:
            if runs:
                journal.close()
            subprocess.run(['umount', str(shown)], check=True)
    assert on_small_disk(read) == [1]


def test_a_journal_that_was_written_while_it_was_read_gives_nothing(path, monkeypatch):
    journal = Journal(path)
    journal.store([ended(1)])
    journal.close()
    monkeypatch.setattr(os, 'access', lambda *_: False)
    monkeypatch.setattr('fleet_core.supervision.history._history_line', None)
    connect = sqlite3.connect

    def connect_and_write(*words, **more):
        database = connect(*words, **more)
        os.utime(path, ns=(0, 0))
        return database
    monkeypatch.setattr(sqlite3, 'connect', connect_and_write)
    with pytest.raises(JournalError, match='try again'):
        list(history(path))
