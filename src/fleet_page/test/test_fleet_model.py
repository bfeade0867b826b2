"""The content of the page, made from the fleet manager's messages."""
from page_builders import graph, page, request, robot, show_fleet, status

from fleet_core.supervision.fleet_stop import NOT_STOPPED, FleetStop, StopCause
from fleet_core.supervision.history import HistoryLine
from fleet_core.supervision.missions import MissionState
from fleet_page.core import fleet_model
from fleet_page.core.acts import Act, ActKind
from fleet_page.core.fleet import ShownPose
from fleet_page.core.fleet_model import FleetModel
from fleet_page.core.readiness import LIMIT, Readiness

STOP = FleetStop(StopCause.PERSON, 'anna (page)', 90.0)


def test_a_fleet_manager_that_falls_silent_counts_as_dead_with_the_time_of_its_last_word():
    model = FleetModel()
    assert model.live.get('fleet') == {'alive': False, 'heard': None}
    model.take_robots([robot()], 100.0)
    assert model.live.get('fleet')['alive']
    model.tick(104.0)
    assert model.live.get('fleet') == {'alive': False, 'heard': 100.0}
    assert model.live.get('robot:a')


def test_a_stop_is_shown_until_the_fleet_goes_on_also_if_the_fleet_manager_dies():
    model = FleetModel()
    model.show_stop(STOP)
    model.take_robots([robot()], 100.0)
    model.tick(200.0)
    assert model.live.get('stop') == {
        'cause': 'PERSON', 'by': 'anna (page)', 'since': 90.0, 'why': ''}
    model.show_stop(NOT_STOPPED)
    assert model.live.get('stop') is None


def test_a_robot_without_a_location_stands_where_its_edge_says():
    model = FleetModel()
    model.graph = graph()
    model.take_robots([robot(fraction=0.5)], 0.0)
    assert model.live.get('pose:a') == [1.5, 0.0, 0.0]
    model.take_places({'a': ShownPose(1.0, 2.0, None)})
    model.take_robots([robot(fraction=0.9)], 0.5)
    assert model.live.get('pose:a') == [1.0, 2.0, None]


def test_a_robot_that_leaves_the_fleet_leaves_the_page():
    model = FleetModel()
    model.take_robots([robot('a'), robot('b')], 0.0)
    model.take_places({'a': ShownPose(0.0, 0.0, 0.0)})
    model.take_robots([robot('b')], 0.5)
    assert model.live.entries('robot:').keys() == {'b'} and model.live.get('pose:a') is None


def test_a_standing_robot_changes_nothing():
    model = FleetModel()
    model.take_robots([robot()], 0.0)
    model.take_places({'a': ShownPose(1.0, 1.0, 0.0)})
    before = model.live.revision
    model.take_robots([robot(seen=200.0, fraction=0.6)], 0.5)
    model.take_places({'a': ShownPose(1.001, 1.0, 0.0)})
    assert model.live.revision == before


def test_a_mission_shows_its_request_whichever_comes_first():
    for first in (True, False):
        model = FleetModel()
        if first:
            model.take_request(request(7, 2, 3))
        model.take_status(status(7))
        if not first:
            model.take_request(request(7, 2, 3))
        shown = model.live.get('mission:7:7000000000')
        assert shown['destinations'] == [2, 3] and shown['by'] == 'anna'


def test_a_mission_of_before_the_start_is_found_in_the_journal():
    model = FleetModel()
    model.take_status(status(7))
    assert model.unknown == {7}
    line = HistoryLine(7, (4, 5), 'agv', 2, MissionState.ACTIVE, 'a', 0, 1.0, 2.0, None, '')
    model.take_history([line])
    assert model.unknown == set()
    assert model.live.get('mission:7:7000000000')['destinations'] == [4, 5]
    model.forget_request(7)
    assert model.unknown == {7}


def test_the_end_of_a_mission_is_when_the_fleet_manager_expects_it():
    model, key = FleetModel(), 'mission:7:7000000000'
    model.take_request(request(7, 2, 3))
    model.take_status(status(7))
    model.take_robots([robot(to_end=60.0)], 1000.0)
    assert model.live.get(key)['ends_at'] == 1060
    before = model.live.revision
    model.take_robots([robot(to_end=58.0)], 1003.0)
    assert model.live.revision == before, 'a change of 1 s is noise'
    model.take_robots([robot(to_end=80.0)], 1004.0)
    assert model.live.get(key)['ends_at'] == 1084
    model.take_robots([robot()], 1005.0)
    assert 'ends_at' not in model.live.get(key)
    model.take_robots([robot(to_end=5.0, mission=8)], 1006.0)
    assert 'ends_at' not in model.live.get(key), 'the robot serves another mission'


def test_only_the_last_ended_missions_stay(monkeypatch):
    monkeypatch.setattr(fleet_model, 'MOST_ENDED', 2)
    model = FleetModel()
    for id in range(1, 6):
        model.take_status(status(id, 'SUCCEEDED'))
    assert [mission['id'] for mission in model.live.entries('mission:').values()] == [4, 5]
    assert model.ended == {'SUCCEEDED': 5}


def test_waiting_distance_and_work_are_summed_up():
    model = FleetModel()
    model.take_robots([robot(waits_for='b')], 0.0)
    model.take_robots([robot(waits_for='b')], 0.5)
    model.take_places({'a': ShownPose(0.0, 0.0, 0.0)})
    model.take_places({'a': ShownPose(1.5, 0.0, 0.0)})
    model.take_places({'a': ShownPose(99.0, 0.0, 0.0)})  # carried, not driven
    sums, edges = model.take_sums()
    assert (sums['a'].distance, sums['a'].busy, sums['a'].waiting) == (1.5, 0.5, 0.5)
    assert edges == {1: 0.5} and model.take_sums() == ({}, {})


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
        shown.take_request(request(7), 'boris@hall (mission)', 5.0)
    shown.take_request(request(8), '', 6.0)
    row, = shown.records.audit(9)
    assert (row['person'], row['act'], row['details']['destinations']) == (
        'boris@hall (mission)', 'send', [2, 3])


def test_an_act_that_was_not_done_says_so_in_the_audit_list(tmp_path):
    shown = page(str(tmp_path))
    shown.noticed('boris', Act(ActKind.MODIFY, mission=7, destinations=(99,)), 5.0)
    shown.noticed('boris', Act(ActKind.MODIFY, mission=8), 6.0)
    shown.take_status(status(7, not_done='modify', reason='the graph has no vertex 99'))
    other, row = shown.records.audit(9)
    assert not row['ok'] and row['outcome'] == 'the graph has no vertex 99' and other['ok']


def test_a_start_tells_once_that_all_robots_are_ready():
    readiness = Readiness()
    assert readiness.words([robot('a', state='OFFLINE'), robot('b')], True, False, 10.0) == ''
    assert readiness.words([], True, False, 11.0) == ''
    assert readiness.words([robot('a'), robot('b', state='OFF_GRAPH')], True, False, 11.5) == ''
    robots = [robot('a'), robot('b', state='IDLE'), robot('c', state='ABSENT')]
    assert readiness.words(robots, False, False, 12.0) == '', 'the graph is being surveyed'
    assert readiness.words(robots, True, False, 12.5) == 'Ready: 2 robots.'
    assert readiness.words(robots, True, False, 13.0) == ''


def test_a_robot_that_is_not_ready_is_named_after_a_while():
    readiness, robots = Readiness(), [robot('a'), robot('b', state='UNKNOWN')]
    assert readiness.words(robots, True, True, 10.0) == ''
    assert readiness.words(robots, True, True, 10.0 + LIMIT) == (
        'Ready: 1 robot. Not ready: b (place unknown). The fleet is stopped: press Go on.')
