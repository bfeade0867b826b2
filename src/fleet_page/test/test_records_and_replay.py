"""The page stores sums, favourites, the audit list and the replay in little disk space."""
import os

import pytest
from page_builders import page, show_fleet

from fleet_core.supervision.history import HistoryLine
from fleet_core.supervision.missions import MissionState
from fleet_page.core import records as records_module
from fleet_page.core.acts import Act, ActKind, ActOutcome
from fleet_page.core.history import history_csv, history_values
from fleet_page.core.records import NamedKind, Records, Sums, TooManyNamed
from fleet_page.core.replay import KEY_PERIOD, SEGMENTS, ReplayRing
from fleet_page.core.robot_events import RobotEvent


def test_the_audit_list_keeps_the_newest_rows(monkeypatch):
    monkeypatch.setattr(records_module, 'MOST_ROWS', 3)
    records = Records(':memory:')
    for time in range(10):
        records.note(time, 'anna', Act(ActKind.OUT, robot='a'), ActOutcome(True, 'done'))
    rows = records.audit(100)
    assert [row['time'] for row in rows] == [9.0, 8.0, 7.0]
    assert rows[0]['details'] == {'robot': 'a'}


@pytest.mark.parametrize('kind', NamedKind)
def test_favourites_and_areas_are_kept_replaced_and_removed(monkeypatch, kind):
    records = Records(':memory:')
    records.keep_named(kind, 'tour', {'destinations': [1]})
    records.keep_named(kind, 'tour', {'destinations': [2]})
    assert [records.named(one) for one in NamedKind if one is not kind] == [{}]
    assert records.named(kind) == {'tour': {'destinations': [2]}}
    monkeypatch.setattr(records_module, 'MOST_NAMED', 1)
    with pytest.raises(TooManyNamed):
        records.keep_named(kind, 'other', {})
    assert records.remove_named(kind, 'tour') and not records.remove_named(kind, 'tour')


def test_sums_of_an_hour_add_up():
    records = Records(':memory:')
    for _ in range(2):
        records.add(3600.0 * 5, {'a': Sums(1.5, 10.0, 5.0, 20.0)}, {3: 5.0})
    assert records.robot_sums(3600.0 * 5) == {'a': Sums(3.0, 20.0, 10.0, 40.0)}
    assert records.edge_waiting(0.0) == [(3, 10.0)] and records.robot_sums(3600.0 * 6) == {}


def test_a_battery_has_one_value_in_each_period_of_the_last_day():
    records, period = Records(':memory:'), records_module.CHARGE_PERIOD
    for now, charge in ((0.0, 0.9), (10.0, 0.8), (period, 0.7)):
        records.keep_charges(now, {'a': charge, 'b': 0.5})
    assert records.charges('a') == [(0, 0.9), (period, 0.7)] and records.charges('c') == []
    records.keep_charges(records_module.KEPT_CHARGE + period, {'a': 0.2})
    assert records.charges('a')[0] == (period, 0.7)


def test_a_robots_newest_events_come_first_and_the_oldest_are_deleted(monkeypatch):
    monkeypatch.setattr(records_module, 'KEPT_EVENTS', 3)
    records = Records(':memory:')
    events = [RobotEvent(float(k), 'ab'[k % 2], 'IDLE', 'NONE', False, '', '', k or None)
              for k in range(6)]
    records.note_events(events)
    assert records.events('a', 9) == [events[4]]
    assert records.events('b', 9) == [events[5], events[3]] and len(records.events('b', 1)) == 1


def line(**values):
    known = {'request_id': 1, 'destinations': (2, 3), 'robot_type': '', 'priority': 0,
             'state': MissionState.SUCCEEDED, 'robot': 'a', 'reached': 2, 'accepted': 100.0,
             'started': 110.0, 'ended': 200.0, 'reason': '', 'requested_by': 'anna (page)'}
    return HistoryLine(**{**known, **values})


def test_the_history_counts_missions_by_hour_and_robot():
    records = Records(':memory:')
    records.add(100.0, {'a': Sums(3.0, 50.0, 5.0, 100.0)}, {3: 5.0})
    lines = [line(), line(ended=3700.0), line(state=MissionState.FAILED), line(ended=None)]
    values = history_values(lines, records.sums(0.0), 0.0, 3800.0)
    assert [(hour['SUCCEEDED'], hour['FAILED']) for hour in values['hours']] == [(1, 1), (1, 0)]
    assert values['robots'] == [{'robot': 'a', 'missions': 2, 'distance': 3.0, 'waiting': 5.0,
                                 'utilisation': 0.5}]
    assert values['mean_waited'] == 10.0


def test_no_spreadsheet_takes_a_cell_of_the_csv_for_a_formula():
    text = history_csv([line(reason='=HYPERLINK("http://evil")', robot='@x')], 0.0)
    assert "'=HYPERLINK" in text and ",'@x," in text
    assert ',anna (page)' in text


def moment(x, state='IDLE'):
    return {'a': [x, 0.0, None, state, '']}


def test_the_replay_finds_every_moment_again(tmp_path):
    ring = ReplayRing(str(tmp_path))
    assert ring.span is None and ring.at(5.0) is None
    for second in range(100):
        ring.add(float(second), {**moment(second), 'b': [0.0, 0.0, 0.0, 'IDLE', '']})
    for kept in (ring, ReplayRing(str(tmp_path))):
        assert kept.at(-1.0) is None
        for second in (0, 1, 29, 30, 31, 77, 99):
            found = kept.at(second + 0.4)
            assert found['t'] == second and found['r']['a'][0] == second and 'b' in found['r']
    assert ring.span[0] == 0.0


def test_the_replay_stays_within_its_size_and_forgets_the_oldest(tmp_path):
    size = 40_000
    ring = ReplayRing(str(tmp_path), size)
    for second in range(3000):
        ring.add(float(second), moment(second))
    used = sum(os.path.getsize(tmp_path / name) for name in os.listdir(tmp_path))
    assert used < size + 2 * size / SEGMENTS
    assert ring.span[0] > 0.0 and ring.span[1] == 2999.0
    assert ring.at(2999.0)['r'] == moment(2999) and ring.at(0.0) is None


def test_a_half_written_line_spoils_no_other(tmp_path):
    ring = ReplayRing(str(tmp_path))
    ring.add(1.0, moment(1))
    ring.add(2.0, moment(2))
    path = next(tmp_path.iterdir())
    path.write_bytes(path.read_bytes()[:-4])
    ring = ReplayRing(str(tmp_path))
    assert ring.at(2.0)['r'] == moment(1)
    ring.add(3.0, moment(3))
    assert ring.at(3.0)['r'] == moment(3)


def test_a_clock_that_is_set_back_leaves_the_replay_in_order(tmp_path):
    ring = ReplayRing(str(tmp_path))
    ring.add(10.0, moment(1))
    ring.add(5.0, moment(2))
    assert ring.span == (10.0, 10.0)
    ring.add(10.0 + KEY_PERIOD, moment(3))
    assert ring.at(10.0)['r'] == moment(1)


def test_a_full_disk_is_told_once_and_the_fleet_is_shown(tmp_path, monkeypatch, caplog):
    shown = page(str(tmp_path))
    monkeypatch.setattr(shown.replay, 'add', lambda *_: (_ for _ in ()).throw(OSError('full')))
    for second in range(5):
        show_fleet(shown, 1000.0 + second)
        shown._summed = 1000.0 + second  # prevents that `tick` writes the sums
        shown.tick(1000.0 + second)
    assert caplog.text.count('full') == 1 and shown.model.live.get('fleet')['alive']
