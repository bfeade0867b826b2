"""The content of the page, made from the fleet manager's messages."""
import pytest
from page_builders import graph, page, request, robot, show_fleet, status

from fleet_core.supervision.fleet_stop import NOT_STOPPED, FleetStop, StopCause
from fleet_core.supervision.history import HistoryLine
from fleet_core.supervision.missions import MissionState
from fleet_core.supervision.outages import Outage
from fleet_page.core import fleet_model
from fleet_page.core.acts import Act, ActKind
from fleet_page.core.fleet import NEVER_HEARD, MissionRequest, RobotGroup, ShownPose, alarm_of
from fleet_page.core.fleet_model import FleetModel
from fleet_page.core.robot_events import RobotEvent, event_between

STOP = FleetStop(StopCause.PERSON, 'anna (page)', 90.0)


def test_a_fleet_manager_that_falls_silent_counts_as_dead_with_the_time_of_its_last_word():
    model = FleetModel()
    assert model.live.get('fleet') == {'alive': False, 'heard': None}
    model.update_robots([robot()], 100.0)
    assert model.live.get('fleet')['alive']
    model.tick(104.0)
    assert model.live.get('fleet') == {'alive': False, 'heard': 100.0}
    assert model.live.get('robot:a')


def test_a_stop_is_shown_until_the_fleet_goes_on_also_if_the_fleet_manager_dies():
    model = FleetModel()
    model.show_stop(STOP)
    model.update_robots([robot()], 100.0)
    model.tick(200.0)
    assert model.live.get('stop') == {
        'cause': 'PERSON', 'by': 'anna (page)', 'since': 90.0, 'why': ''}
    model.show_stop(NOT_STOPPED)
    assert model.live.get('stop') is None


@pytest.mark.parametrize('values, group, alarm', [
    ({'state': 'IDLE', 'mission': None}, RobotGroup.IDLE, ''), ({}, RobotGroup.DRIVING, ''),
    ({'waits_for': 'b', 'wait': 'TRAFFIC'}, RobotGroup.WAITING, ''),
    ({'waits_for': 'step 1', 'wait': 'STEP'}, RobotGroup.WORKING, ''),
    ({'waits_for': 'step 1 needs an answer', 'wait': 'PERSON'}, RobotGroup.TROUBLE, ''),
    ({'state': 'IDLE', 'mission': None, 'load': 'LOADED', 'wait': 'PERSON'}, RobotGroup.TROUBLE,
     'LADEN'),
    ({'state': 'CHARGING'}, RobotGroup.CHARGING, ''),
    ({'state': 'OFFLINE', 'outage': 'SILENT'}, RobotGroup.TROUBLE, 'SILENT'),
    ({'state': 'OFFLINE', 'outage': 'SILENT', 'mission': None}, RobotGroup.AWAY, ''),
    ({'state': 'OFFLINE', 'outage': 'CLOCK'}, RobotGroup.TROUBLE, 'CLOCK'),
    ({'state': 'UNKNOWN', 'outage': 'UNSEEN'}, RobotGroup.TROUBLE, NEVER_HEARD),
    ({'state': 'OUT_OF_SERVICE', 'outage': 'OUT_OF_SERVICE'}, RobotGroup.AWAY, '')])
def test_each_robot_counts_once_and_its_alarm_says_why(values, group, alarm):
    model = FleetModel()
    model.update_robots([robot(**values)], 100.0)
    counts = model.live.get('counts')
    assert counts[group.value] == 1 == sum(counts[one.value] for one in RobotGroup)
    assert (model.live.get('alarm:robot:a') or {'cause': ''})['cause'] == alarm


def test_a_robot_that_does_not_work_has_its_fault_and_the_time_since_when():
    model = FleetModel()
    model.update_robots([robot()], 100.0)
    assert (model.live.get('robot:a')['fault'], model.live.get('robot:a')['fault_since']) == ('', 0)
    for now, outage, since in ((110.0, 'OUT_OF_SERVICE', 110), (120.0, 'OUT_OF_SERVICE', 110),
                               (130.0, 'FAILED', 130), (140.0, 'NONE', 0)):
        model.update_robots([robot(outage=outage)], now)
        shown = model.live.get('robot:a')
        assert (shown['fault'], shown['fault_since']) == ('' if outage == 'NONE' else outage, since)


@pytest.mark.parametrize('outage', Outage)
def test_every_outage_that_ends_only_by_a_person_is_an_alarm_or_was_ordered(outage):
    shown = alarm_of(robot(outage=outage.name, state='OFFLINE'))
    assert bool(shown) or not outage.needs_person or outage is Outage.OUT_OF_SERVICE


def test_an_alarm_keeps_its_time_and_who_has_seen_it_until_its_cause_changes():
    model = FleetModel()

    def told(now, *robots):
        model.update_robots(robots, now)
        return model.live.get('alarm:robot:a')
    failed = robot(state='FAILED', outage='FAILED')
    assert told(100.0, failed) == {'cause': 'FAILED', 'since': 100, 'seen_by': ''}
    assert model.acknowledge('robot:a', 'anna') and model.acknowledge('robot:a', 'boris')
    assert told(200.0, failed) == {'cause': 'FAILED', 'since': 100, 'seen_by': 'anna'}
    assert told(300.0, robot(state='STOPPED', outage='STOPPED'))['seen_by'] == ''
    assert told(400.0, robot()) is None and not model.acknowledge('robot:a', 'anna')
    assert told(500.0, failed)['since'] == 500
    assert told(600.0) is None


def test_a_mission_that_needs_a_person_is_an_alarm_as_long_as_it_does():
    model = FleetModel()
    model.update_status(status(7, 'NEEDS_PERSON', told=100.0))
    name, = model.live.entries('alarm:')
    assert model.live.entries('mission:').keys() == {name[len('mission:'):]}
    model.update_status(status(7, told=110.0))
    assert model.live.entries('alarm:') == {}


def test_the_missions_done_in_the_last_hour_are_counted_also_those_before_the_start():
    model = FleetModel()
    lines = [HistoryLine(id, (2,), '', 0, state, 'a', 1, 0.0, 10.0, ended, '') for id, state, ended
             in ((1, MissionState.SUCCEEDED, 50.0), (2, MissionState.FAILED, 60.0),
                 (3, MissionState.ACTIVE, None), (4, MissionState.SUCCEEDED, 101.0))]
    model.count_done(lines, 100.0)
    model.update_status(status(4, 'SUCCEEDED', told=101.0))
    model.update_status(status(4, 'SUCCEEDED', told=102.0))
    model.tick(200.0)
    assert model.live.get('counts')['done'] == 2
    model.tick(50.0 + fleet_model.HOUR + 1.0)
    assert model.live.get('counts')['done'] == 1


def test_a_mission_shows_when_it_started_and_ended():
    model = FleetModel()
    for state, told in (('PENDING', 10.0), ('ACTIVE', 20.0), ('PAUSED', 30.0), ('ACTIVE', 40.0),
                        ('SUCCEEDED', 50.0), ('SUCCEEDED', 60.0)):
        model.update_status(status(7, state, told=told))
    shown, = model.live.entries('mission:').values()
    assert (shown['started'], shown['ended']) == (20, 50)


def test_robots_are_numbered_in_the_order_of_the_fleet_and_keep_their_numbers():
    model = FleetModel()
    model.update_robots([robot('b'), robot('a')], 0.0)
    model.update_robots([robot('c'), robot('a')], 1.0)
    assert {name: shown['number'] for name, shown in model.live.entries('robot:').items()} == {
        'a': 1, 'c': 2}


def test_a_robot_without_a_location_stands_where_its_edge_says():
    model = FleetModel()
    model.graph = graph()
    model.update_robots([robot(fraction=0.5)], 0.0)
    assert model.live.get('pose:a') == [1.5, 0.0, 0.0]
    model.update_places({'a': ShownPose(1.0, 2.0, None)})
    model.update_robots([robot(fraction=0.9)], 0.5)
    assert model.live.get('pose:a') == [1.0, 2.0, None]


def test_a_robot_that_leaves_the_fleet_leaves_the_page():
    model = FleetModel()
    model.update_robots([robot('a'), robot('b')], 0.0)
    model.update_places({'a': ShownPose(0.0, 0.0, 0.0)})
    model.update_robots([robot('b')], 0.5)
    assert model.live.entries('robot:').keys() == {'b'} and model.live.get('pose:a') is None


def test_a_standing_robot_changes_nothing():
    model = FleetModel()
    model.update_robots([robot()], 0.0)
    model.update_places({'a': ShownPose(1.0, 1.0, 0.0)})
    before = model.live.revision
    model.update_robots([robot(seen=200.0, fraction=0.6)], 0.5)
    model.update_places({'a': ShownPose(1.001, 1.0, 0.0)})
    assert model.live.revision == before


def test_a_mission_shows_its_request_whichever_comes_first():
    for first in (True, False):
        model = FleetModel()
        if first:
            model.note_request(request(7, 2, 3))
        model.update_status(status(7))
        if not first:
            model.note_request(request(7, 2, 3))
        shown = model.live.get('mission:7:7000000000')
        assert shown['destinations'] == [2, 3] and shown['by'] == 'anna'


def test_a_mission_of_before_the_start_is_found_in_the_journal():
    model = FleetModel()
    model.update_status(status(7))
    assert model.unknown == {7}
    line = HistoryLine(7, (4, 5), 'agv', 2, MissionState.ACTIVE, 'a', 0, 1.0, 2.0, None, '')
    model.note_history([line])
    assert model.unknown == set()
    assert model.live.get('mission:7:7000000000')['destinations'] == [4, 5]
    model.forget_request(7)
    assert model.unknown == {7}


def test_the_end_of_a_mission_is_when_the_fleet_manager_expects_it():
    model, key = FleetModel(), 'mission:7:7000000000'
    model.note_request(request(7, 2, 3))
    model.update_status(status(7))
    model.update_robots([robot(to_end=60.0)], 1000.0)
    assert model.live.get(key)['ends_at'] == 1060
    before = model.live.revision
    model.update_robots([robot(to_end=58.0)], 1003.0)
    assert model.live.revision == before, 'a change of 1 s is noise'
    model.update_robots([robot(to_end=80.0)], 1004.0)
    assert model.live.get(key)['ends_at'] == 1084
    model.update_robots([robot()], 1005.0)
    assert 'ends_at' not in model.live.get(key)
    model.update_robots([robot(to_end=5.0, mission=8)], 1006.0)
    assert 'ends_at' not in model.live.get(key), 'the robot serves another mission'


def test_only_the_last_ended_missions_stay(monkeypatch):
    monkeypatch.setattr(fleet_model, 'MOST_ENDED', 2)
    model = FleetModel()
    for id in range(1, 6):
        model.update_status(status(id, 'SUCCEEDED'))
    assert [mission['id'] for mission in model.live.entries('mission:').values()] == [4, 5]
    assert model.ended == {'SUCCEEDED': 5}


def test_a_robot_at_a_step_does_not_wait():
    model = FleetModel()
    for now in (0.0, 0.5):
        model.update_robots([robot(waits_for='step 1', wait='STEP')], now)
    sums, edges = model.pop_sums()
    assert (sums['a'].busy, sums['a'].waiting, edges) == (0.5, 0.0, {})


def test_what_happened_to_a_robot_is_told_once_and_not_at_the_first_report():
    model = FleetModel()
    fails = robot(state='FAILED', outage='FAILED', waits_for='wheel blocked')
    for now, one in ((1.0, robot()), (2.0, robot(edge=2, battery=0.5)), (3.0, fails), (4.0, fails)):
        model.update_robots([one], now)
    assert model.pop_events() == [
        RobotEvent(3.0, 'a', 'FAILED', 'FAILED', False, 'FAILED', 'wheel blocked', 7)]
    assert model.pop_events() == []


@pytest.mark.parametrize('values', [
    {'state': 'IDLE'}, {'wait': 'STEP'}, {'mission': 8}, {'mission': None},
    {'state': 'OFFLINE', 'outage': 'SILENT'}])
def test_each_change_of_what_a_robot_does_is_an_event(values):
    assert event_between(robot(), robot(**values), 1.0) is not None
    assert event_between(robot(**values), robot(**values), 1.0) is None


def test_waiting_distance_and_work_are_summed_up():
    model = FleetModel()
    waits = robot(waits_for='b', wait='TRAFFIC')
    model.update_robots([waits], 0.0)
    model.update_robots([waits], 0.5)
    model.update_places({'a': ShownPose(0.0, 0.0, 0.0)})
    model.update_places({'a': ShownPose(1.5, 0.0, 0.0)})
    model.update_places({'a': ShownPose(99.0, 0.0, 0.0)})  # carried, not driven
    sums, edges = model.pop_sums()
    assert (sums['a'].distance, sums['a'].busy, sums['a'].waiting) == (1.5, 0.5, 0.5)
    assert edges == {1: 0.5} and model.pop_sums() == ({}, {})


def test_the_page_records_what_became_of_a_mission(tmp_path):
    from fleet_page.core.acts import Act, ActKind, ActOutcome
    from fleet_page.core.roles import LOCAL
    shown = page(str(tmp_path))
    shown.done(LOCAL, Act(ActKind.SEND, destinations=(2,)), ActOutcome(True, 'sent', 9), 1.0)
    assert shown.records.audit(1)[0]['outcome'] == 'sent'
    show_fleet(shown)
    assert shown.records.audit(1)[0]['outcome'] == 'SUCCEEDED a'


def test_what_others_ask_for_stands_in_the_audit_list_once(tmp_path):
    shown = page(str(tmp_path))
    for _ in range(2):  # a request is sent again until it is acknowledged
        shown.note_request(request(7), 'boris@hall (mission)', 5.0)
    shown.note_request(request(8), '', 6.0)
    row, = shown.records.audit(9)
    assert (row['person'], row['act'], row['details']['destinations']) == (
        'boris@hall (mission)', 'send', [2, 3])


def test_an_act_that_was_not_done_says_so_in_the_audit_list(tmp_path):
    shown = page(str(tmp_path))
    shown.noticed('boris', Act(ActKind.MODIFY, mission=7, destinations=(99,)), 5.0)
    shown.noticed('boris', Act(ActKind.MODIFY, mission=8), 6.0)
    shown.update_status(status(7, not_done='modify', reason='the graph has no vertex 99'))
    other, row = shown.records.audit(9)
    assert not row['ok'] and row['outcome'] == 'the graph has no vertex 99' and other['ok']


def test_the_mission_of_a_template_has_the_destinations_that_the_fleet_manager_tells(tmp_path):
    shown = page(str(tmp_path))
    asked = MissionRequest(3, 3 * 10 ** 9, (), '', '', 0, 'anna', 'pallet', (('to', '5'),))
    shown.note_request(asked, 'anna', 100.0)
    shown.update_status(status(3, 'PENDING', destinations=(4, 5)))
    assert shown.model.live.get(f'mission:3:{3 * 10 ** 9}')['destinations'] == [4, 5]
    (row,) = shown.records.audit(10)
    assert (row['act'], row['details']) == (
        'run', {'name': 'pallet', 'arguments': [['to', '5']]})


def test_areas_are_told_at_first_and_after_each_change(tmp_path):
    told = []
    shown = page(str(tmp_path), tell_areas=told.append)
    shown.change_named(Act(ActKind.ADD_AREA, name='bay', edges=(2, 3)))
    shown.change_named(Act(ActKind.ADD_FAVOURITE, name='tour', destinations=(2,)))
    assert told == [{}, {'bay': {'edges': [2, 3]}}]
