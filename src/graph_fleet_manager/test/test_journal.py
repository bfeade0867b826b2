"""The file of the journal: other layouts, a second user, a file that vanishes, its growth."""
from __future__ import annotations

import json
import os
import shutil
import sqlite3
from dataclasses import replace

import pytest
from fleet_builders import AGV, corridor

from graph_fleet_manager.supervision.journal import Journal, history
from graph_fleet_manager.supervision.journal_file import (
    JournalError,
    JournalUnavailable,
    UnknownLayout,
)
from graph_fleet_manager.supervision.missions import (
    Acceptance,
    Mission,
    MissionBook,
    MissionState,
    Request,
)

ACCEPTANCE = Acceptance(corridor(5), {'a': AGV})
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


class Clock:
    """Seconds since 1970, as they are set."""

    now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def path(tmp_path) -> str:
    return str(tmp_path / 'fleet.sqlite')


def write_0_2(path: str) -> None:
    """A file as version 0.2 left it, with an open mission and a robot."""
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
    assert journal.robots()['a'].client.edges == (1, -2)
    assert (journal.value('route_id'), journal.last_serial()) == (40, 3)
    line, = history(path)
    assert (line.request_id, line.accepted) == (7, 500.0)
    journal.close()
    Journal(path).close()  # a second time there is nothing left to migrate


@pytest.mark.parametrize('change, says', [
    ('ALTER TABLE mission ADD COLUMN colour TEXT', 'colour'),
    ('PRAGMA user_version = 99', 'version 99'),
    ("UPDATE robot SET memory = '{}'", 'cannot be read'),
    ("UPDATE mission SET state = 77", 'cannot be read')])
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
    for number in range(30):
        journal.store(values={f'{number}' * 200: number})
        if number % 10 == 9:
            journal._db.execute('PRAGMA wal_checkpoint(PASSIVE)')
            journal._file.committed()
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
    assert journal.forget(90 * DAY, most=2) == 2, 'a little at a time'
    assert journal.forget(90 * DAY) == 1
    assert [line.request_id for line in history(path)] == [1, 5, 6]
    clock.now += 91 * DAY
    journal.forget(90 * DAY)
    assert journal.last_serial() == 6, 'no serial is given twice'
    assert [line.request_id for line in history(path)] == [1, 6]


def test_the_history_is_read_page_by_page(path, monkeypatch):
    monkeypatch.setattr('graph_fleet_manager.supervision.journal._PAGE', 4)
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
    assert journal.find(replace(sent, destinations=(3,), priority=9)), 'MODIFY may have changed it'


def test_errors_name_the_file_and_the_way_out(path):
    with open(path, 'w') as stream:
        stream.write('no database' * 500)
    with pytest.raises(JournalError, match='fleet.sqlite'):
        Journal(path)
