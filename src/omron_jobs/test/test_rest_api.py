"""The REST interface without I/O: the paths and records of FLOW Core's Integration Toolkit.

The table of names below belongs to the test: it was copied from the sources, not from the server.
"""
from __future__ import annotations

import json
from typing import Any, Dict, List, Optional, Tuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from job_fleet import Disk, FakeFleet, tell

from omron_jobs.core.client_session import JobServer
from omron_jobs.core.job_book import JobBook
from omron_jobs.core.job_commands import JobCommands, JobSite
from omron_jobs.core.job_words import RobotStatus
from omron_jobs.core.jobs import JobMissionState
from omron_jobs.core.rest_api import RestAnswer, RestApi, stream_of
from omron_jobs.core.rest_records import RestRecords
from omron_jobs.core.rest_words import RestType
from omron_jobs.core.robots import RobotNews

State = JobMissionState
PATHS = {
    'JobRequest': ('ByKey', 'UpdatedSince', 'ByJobId', 'ByStatus', 'ByAssignedJobId', 'Stream'),
    'Pickup': ('ByKey', 'UpdatedSince', 'ByJobId', 'ByStatus', 'ByAssignedJobId', 'Stream'),
    'Dropoff': ('ByKey', 'UpdatedSince', 'ByJobId', 'ByStatus', 'ByAssignedJobId', 'ByRobot',
                'Stream'),
    'PickupDropoff': ('ByKey', 'UpdatedSince', 'ByJobId', 'ByStatus', 'ByAssignedJobId', 'Stream'),
    'JobCancel': ('ByKey', 'UpdatedSince'),
    'JobSegmentModify': ('ByKey', 'UpdatedSince', 'BySegmentId'),
    'Job': ('ByKey', 'UpdatedSince', 'History', 'ByJobId', 'ByLastAssignedRobot', 'ByStatus',
            'Stream'),
    'JobSegment': ('ByKey', 'UpdatedSince', 'History', 'ByStatus', 'ByJob', 'ByRobot',
                   'ByGoalName', 'Stream'),
    'Robot': ('ByKey', 'UpdatedSince', 'History', 'ByStatus', 'BySubStatus', 'Stream'),
    'RobotFault': ('ByKey', 'UpdatedSince', 'History', 'ByRobot', 'ByType', 'ByName', 'ByActive',
                   'Stream'),
    'Goal': ('ByKey', 'UpdatedSince'),
    'DataStoreItem': ('ByKey', 'UpdatedSince', 'ByGroupName', 'ByItemName'),
    'DataStoreValue': ('ByKey', 'UpdatedSince'),
}


class Site:
    """A server with a fleet. `ask` and `post` act as a REST client, `arcl` as an ARCL client."""

    def __init__(self, disk: Optional[Disk] = None, fleet: Optional[FakeFleet] = None,
                 now: float = 1000.0) -> None:
        self.disk, self.fleet, self.now = disk or Disk(), fleet or FakeFleet(), now
        ids = iter(range(1 + len(self.disk.jobs), 10 ** 6))
        self.book = JobBook(self.disk.jobs.values(), self.disk.counters, self.disk,
                            lambda: int(self.now * 1000), lambda: next(ids))
        self.site = JobSite()
        self.site.goals = {'x': 1, 'y': 2, 'z': 3}
        self.site.robots = {'r1': RobotNews(RobotStatus.AVAILABLE, 'Available')}
        self.server = JobServer(JobCommands(self.book, self.site), b'p')
        self.records = RestRecords(self.book, self.site, lambda: int(self.now * 1000),
                                   self.disk.posted)
        self.server.on_changes = self.records.announce
        self.api = RestApi(self.book, self.site, self.records, self.server.announce)
        self.client = self.server.connect()
        self.client.receive(b'p\n')
        self.client.output.clear()
        self.told: List[Tuple[str, Dict[str, Any]]] = []
        self.records.listeners.append(lambda kind, one: self.told.append((kind.value, one)))

    def ask(self, path: str) -> Any:
        answer = self.get(path)
        assert answer.status == 200, answer.body
        return json.loads(json.dumps(answer.body))

    def get(self, path: str) -> RestAnswer:
        path, _, query = path.partition('?')
        pairs = dict(one.split('=', 1) for one in query.split('&') if one)
        return self.api.answer('GET', path, pairs, b'')

    def post(self, path: str, record: Any) -> RestAnswer:
        return self.api.answer('POST', path, {}, json.dumps(record).encode())

    def made(self, path: str, record: Any) -> Dict[str, Any]:
        answer = self.post(path, record)
        assert answer.status == 201, answer.body
        return dict(answer.body)

    def arcl(self, line: str) -> List[str]:
        self.client.output.clear()
        self.client.receive(line.encode() + b'\n')
        return self.client.output.decode().split('\r\n')[:-1]

    def exchange(self) -> None:
        self.now += 3.0
        for message in self.book.due(self.now):
            for key, shown in list(self.fleet.handle(message)):
                self.server.announce(tell(self.book, key, shown, self.now))

    def drive(self, number: int = 0, *, reach: bool = False) -> None:
        """The robot of a mission drives, or reaches its next stop."""
        self.now += 1.0
        key = list(self.fleet.missions)[number]
        if reach:
            self.fleet.reach(key)
        else:
            self.fleet.set(key, State.ACTIVE, 'r1')
        self.server.announce(tell(self.book, key, self.fleet.missions[key].shown, self.now))
        self.server.announce(self.book.hear_drives(self.fleet.drives()))


# -- records ---------------------------------------------------------------------------------------


@pytest.mark.parametrize('form', [
    {'defaultPriority': False, 'details': [
        {'goal': 'x', 'priority': 5, 'segmentType': 'Pickup'},
        {'goal': 'y', 'priority': 6, 'segmentType': 'Dropoff'}]},
    {'details': [{'pickupGoal': 'x', 'priority': 5}, {'dropoffGoal': 'y', 'priority': 6}]}])
def test_both_forms_of_a_job_request_make_the_same_job(form):
    site = Site()
    record = site.made('/JobRequest', {'namekey': 'own', 'jobId': 'job7', **form})
    stamp = {'millis': 1000000}
    assert record == {
        'namekey': 'own', 'jobId': 'job7', 'defaultPriority': False, 'details': [
            {'goal': 'x', 'priority': 5, 'segmentType': 'Pickup'},
            {'goal': 'y', 'priority': 6, 'segmentType': 'Dropoff'}],
        'status': 'Pending', 'assignedJobId': 'job7', 'audit': {'crt': stamp, 'upd': stamp}}
    assert site.ask('/JobRequest/ByKey/own') == record
    assert site.ask('/Job/ByJobId/job7') == [{
        'namekey': 'JOB1', 'upd': stamp, 'jobId': 'job7', 'jobType': 'PD',
        'queuedTimestamp': stamp, 'completedTimestamp': None, 'status': 'Pending',
        'linkedJob': None, 'failCount': 0, 'lastAssignedRobot': '', 'cancelReason': None}]
    assert site.ask('/JobSegment/ByJob/JOB1')[1] == {
        'namekey': 'DROPOFF2', 'upd': stamp, 'seq': 2, 'segmentId': 'DROPOFF2',
        'segmentType': 'Dropoff', 'status': 'Pending', 'subStatus': 'ID_PICKUP1', 'job': 'JOB1',
        'robot': None, 'linkedJobSegment': 'PICKUP1', 'goalName': 'y', 'priority': 6,
        'completedTimestamp': None, 'cancelReason': None}


def test_a_detail_may_name_both_goals_and_the_defaults_count_instead_of_its_priority():
    site = Site()
    record = site.made('/JobRequest', {
        'namekey': 'a', 'jobId': '', 'defaultPriority': True,
        'details': [{'pickupGoal': 'x', 'dropoffGoal': 'y', 'priority': 3}]})
    assert [one['priority'] for one in record['details']] == [10, 20]
    assert record['assignedJobId'] == 'JOB1'


@pytest.mark.parametrize('path, record, kind, goals, priorities', [
    ('/Pickup', {'goal': 'x', 'priority': 4}, 'P', ['x'], [4]),
    ('/Dropoff', {'goal': 'y', 'robot': 'r1'}, 'D', ['y'], [20]),
    ('/PickupDropoff', {'pickupGoal': 'x', 'pickupPriority': 1, 'dropoffGoal': 'z',
                        'dropoffPriority': 2}, 'PD', ['x', 'z'], [1, 2]),
    ('/JobRequest', {'details': [{'pickupGoal': 'x'}, {'pickupGoal': 'y'}, {'dropoffGoal': 'z'}]},
     'M', ['x', 'y', 'z'], [10, 10, 20])])
def test_each_request_makes_a_job_of_its_type(path, record, kind, goals, priorities):
    site = Site()
    made = site.made(path, record)
    assert made['status'] == 'Pending' and made['namekey']
    assert site.ask(f'{path}/ByKey/{made["namekey"]}') == made
    assert site.ask(f'{path}/ByAssignedJobId/JOB1') == [made]
    job, = site.ask('/Job/UpdatedSince?sinceTime=0')
    assert job['jobType'] == kind
    segments = site.ask('/JobSegment/ByJob/JOB1')
    assert [(one['goalName'], one['priority']) for one in segments] == list(zip(goals, priorities))
    site.exchange()
    (mission,) = site.fleet.missions.values()
    assert mission.shown.places == tuple(' xyz'.index(goal) for goal in goals)
    assert site.book.jobs[0].robot == record.get('robot', '')


def test_a_pickup_and_dropoff_where_a_robot_brings_its_load_is_linked_and_stays_so():
    site = Site()
    site.made('/PickupDropoff', {'pickupGoal': 'x', 'dropoffGoal': 'y', 'jobId': 'one'})
    site.exchange()
    site.drive()
    site.drive(reach=True)
    site.made('/PickupDropoff', {'pickupGoal': 'y', 'dropoffGoal': 'z', 'jobId': 'two'})
    again = Site(site.disk, site.fleet, site.now + 5)
    for one in (site, again):
        assert [job['linkedJob'] for job in one.ask('/Job/UpdatedSince')] == [None, 'JOB1']
        assert {segment['robot'] for segment in one.ask('/JobSegment/ByJob/JOB3')} == {'r1'}
        assert one.book.jobs[1].robot == 'r1'


def test_every_path_of_the_facts_is_answered():
    site = Site()
    for kind, ways in PATHS.items():
        for how in ways:
            if how == 'Stream':
                assert stream_of(f'/{kind}/Stream') is RestType(kind)
            elif how == 'ByKey':
                assert site.get(f'/{kind}/ByKey/nothing').status == 404
            elif how in ('UpdatedSince', 'History'):
                for record in site.ask(f'/{kind}/{how}?sinceTime=0&namekey=r1'):
                    assert record['namekey'] and ('upd' in record or 'audit' in record)
            else:
                assert site.ask(f'/{kind}/{how}/nothing') == []
    assert site.ask('/DataStoreValueLatest/Robots') == [
        {'namekey': 'Robots', 'value': '1', 'upd': {'millis': 1000000}}]
    assert site.ask('/DataStoreItem/ByGroupName/JobCounts')[0]['itemName'] == 'CompletedJobs'


REQUEST = ('namekey', 'jobId', 'status', 'assignedJobId', 'audit')
FIELDS = {  # the fields of each type of records
    'JobRequest': (*REQUEST, 'defaultPriority', 'details'),
    'Pickup': (*REQUEST, 'goal', 'priority'),
    'Dropoff': (*REQUEST, 'robot', 'goal', 'priority'),
    'PickupDropoff': (*REQUEST, 'pickupGoal', 'pickupPriority', 'dropoffGoal', 'dropoffPriority'),
    'JobCancel': ('namekey', 'cancelType', 'cancelValue', 'cancelReason', 'status', 'audit'),
    'JobSegmentModify': ('namekey', 'segmentId', 'segmentNamekey', 'priority', 'goal', 'status',
                         'audit'),
    'Job': ('namekey', 'upd', 'jobId', 'jobType', 'queuedTimestamp', 'completedTimestamp', 'status',
            'linkedJob', 'failCount', 'lastAssignedRobot', 'cancelReason'),
    'JobSegment': ('namekey', 'upd', 'seq', 'segmentId', 'segmentType', 'status', 'subStatus',
                   'job', 'robot', 'linkedJobSegment', 'goalName', 'priority',
                   'completedTimestamp', 'cancelReason'),
    'Robot': ('namekey', 'upd', 'status', 'subStatus'),
    'RobotFault': ('namekey', 'upd', 'robot', 'active', 'driving', 'critical', 'clearedOnGo',
                   'clearedOnAck', 'application', 'name', 'type', 'shortDescription',
                   'longDescription'),
    'Goal': ('namekey', 'upd'),
    'DataStoreItem': ('namekey', 'upd', 'groupName', 'itemName', 'displayName'),
    'DataStoreValue': ('namekey', 'upd', 'value'),
}


def test_each_record_has_the_fields_of_the_sources_and_no_others():
    site = Site()
    for path, record in (
            ('JobRequest', {'details': [{'pickupGoal': 'x'}]}), ('Pickup', {'goal': 'x'}),
            ('Dropoff', {'goal': 'x', 'robot': 'r1'}),
            ('PickupDropoff', {'pickupGoal': 'x', 'dropoffGoal': 'y'}),
            ('JobCancel', {'robot': 'r1'}),
            ('JobSegmentModify', {'segmentId': 'PICKUP1', 'priority': 2})):
        site.made(f'/{path}', record)
    site.site.robots = {'r1': RobotNews(RobotStatus.UNAVAILABLE, 'EStopPressed')}
    site.records.refresh()
    assert set(FIELDS) == set(PATHS)
    for path, names in FIELDS.items():
        records = site.ask(f'/{path}/UpdatedSince?sinceTime=0')
        assert records, path
        for record in records:
            assert sorted(record) == sorted(names), path


def test_robots_their_faults_and_the_goals_are_records():
    site = Site()
    assert site.ask('/Robot/UpdatedSince?sinceTime=0') == [
        {'namekey': 'r1', 'upd': {'millis': 1000000}, 'status': 'Available',
         'subStatus': 'Available'}]
    assert [one['namekey'] for one in site.ask('/Goal/UpdatedSince?sinceTime=0')] == ['x', 'y', 'z']
    site.now += 5
    site.site.robots = {'r1': RobotNews(RobotStatus.UNAVAILABLE, 'EStopPressed')}
    site.records.refresh()
    fault, = site.ask('/RobotFault/ByActive/true')
    assert fault == {
        'namekey': 'r1:EStopPressed', 'upd': {'millis': 1005000}, 'robot': 'r1', 'active': True,
        'driving': True, 'critical': False, 'clearedOnGo': False, 'clearedOnAck': False,
        'application': False, 'name': 'EStopPressed', 'type': 'Fault_Driving',
        'shortDescription': 'EStopPressed', 'longDescription': 'r1 serves no jobs (EStopPressed)'}
    site.site.robots = {'r1': RobotNews(RobotStatus.AVAILABLE, 'Available')}
    site.records.refresh()
    assert site.ask('/RobotFault/ByActive/true') == []
    assert [one['active'] for one in site.ask('/RobotFault/History?sinceTime=0')] == [True, False]
    assert [one['status'] for one in site.ask('/Robot/History?sinceTime=0&namekey=r1')] == [
        'Available', 'UnAvailable', 'Available']


def test_a_stream_tells_the_course_of_a_job_in_the_order_of_arcl():
    site = Site()
    site.made('/Pickup', {'goal': 'x', 'jobId': 'one'})
    site.exchange()
    site.drive()
    site.made('/JobSegmentModify', {'segmentId': 'PICKUP1', 'goal': 'y'})
    site.exchange()
    site.drive()
    site.drive(reach=True)
    course = [(one['status'], one['subStatus']) for kind, one in site.told if kind == 'JobSegment']
    assert course[:5] == [('Pending', 'None'), ('InProgress', 'UnAllocated'),
                          ('InProgress', 'Allocated'), ('InProgress', 'Driving'),
                          ('Modifying', 'Driving')]
    assert [status for status, _ in course[5:8]] == ['InterruptedByModify', 'Modified', 'Pending']
    assert course[-1] == ('Completed', 'None')
    jobs = [one['status'] for kind, one in site.told if kind == 'Job']
    assert [one for k, one in enumerate(jobs) if jobs[k - 1:k] != [one]] == [
        'Pending', 'InProgress', 'Modifying', 'Pending', 'InProgress', 'Completed']
    assert site.ask('/Pickup/ByStatus/Completed')[0]['assignedJobId'] == 'one'
    assert site.ask('/Job/ByLastAssignedRobot/r1')[0]['completedTimestamp'] is not None


@pytest.mark.parametrize('begins', [False, True])
@pytest.mark.parametrize('record, is_of_begun', [
    ({'cancelType': 'SegmentId', 'cancelValue': 'DROPOFF2'}, None),
    ({'cancelType': 'JobId', 'cancelValue': 'one'}, None),
    ({'cancelType': 'RobotName', 'cancelValue': 'r1'}, True),
    ({'cancelType': 'Status', 'cancelValue': 'Pending'}, False),
    ({'cancelType': 'SegmentNamekey', 'cancelValue': 'PICKUP1'}, None),
    ({'cancelType': 'JobNamekey', 'cancelValue': 'JOB1'}, None),
    ({'cancelType': 'RemoveSegmentId', 'cancelValue': 'PICKUP1'}, None),
    ({'cancelType': 'RemoveSegmentNamekey', 'cancelValue': 'DROPOFF2'}, None),
    ({'robot': 'r1'}, True), ({'jobNamekey': 'JOB1'}, None), ({'jobId': 'one'}, None)])
def test_a_job_is_cancelled_in_each_way(record, is_of_begun, begins):
    site = Site()
    site.made('/PickupDropoff', {'pickupGoal': 'x', 'dropoffGoal': 'y', 'jobId': 'one'})
    site.exchange()
    if begins:
        site.drive()
    made = site.made('/JobCancel', {**record, 'cancelReason': 'too late'})
    assert (made['status'], made['cancelReason']) == ('Completed', 'too_late')
    assert site.ask(f'/JobCancel/ByKey/{made["namekey"]}') == made
    site.exchange()
    job, = site.ask('/Job/ByJobId/one')
    if is_of_begun in (None, begins):
        assert (job['status'], job['cancelReason']) == ('Cancelled', 'too_late')
        assert {one['cancelReason'] for one in site.ask('/JobSegment/ByStatus/Cancelled')} == {
            'too_late'}
    else:
        assert job['status'] in ('Pending', 'InProgress')


def test_a_priority_is_changed_until_the_segment_begins():
    site = Site()
    site.made('/Pickup', {'goal': 'x'})
    made = site.made('/JobSegmentModify', {'namekey': 'm', 'segmentNamekey': 'PICKUP1',
                                           'priority': 3})
    assert made == {**site.ask('/JobSegmentModify/BySegmentId/PICKUP1')[0]}
    assert (made['priority'], made['goal'], made['status']) == (3, None, 'Completed')
    assert site.ask('/JobSegment/ByKey/PICKUP1')['priority'] == 3
    site.exchange()
    site.drive()
    assert site.post('/JobSegmentModify', {'segmentId': 'PICKUP1', 'priority': 4}).status == 400
    assert site.post('/JobSegmentModify', {'segmentId': 'PICKUP9', 'priority': 4}).status == 404


def test_what_is_asked_since_a_time_misses_no_change():
    site = Site()
    site.made('/Pickup', {'goal': 'x', 'jobId': 'one'})
    site.now += 10
    site.made('/Pickup', {'goal': 'y', 'jobId': 'two'})
    later = site.ask('/Job/UpdatedSince?sinceTime=1010000')
    assert [one['jobId'] for one in later] == ['two']
    site.now -= 100  # the clock is set back
    site.exchange()
    site.drive()
    assert {one['jobId'] for one in site.ask('/Job/UpdatedSince?sinceTime=1010000')} == {
        'one', 'two'}
    assert site.get('/Job/UpdatedSince?sinceTime=yesterday').status == 400


# -- one truth -------------------------------------------------------------------------------------


WORDS = {'Completed': 'Completed', 'Pending': 'Pending', 'InProgress': 'InProgress',
         'Cancelled': 'Cancelled', 'Failed': 'Failed', 'Interrupted': 'Interrupted',
         'Cancelling': 'Cancelling'}


def same_in_both(site: Site) -> None:
    for job in site.ask('/Job/UpdatedSince?sinceTime=0'):
        segments = site.ask(f'/JobSegment/ByJob/{job["namekey"]}')
        for one in segments:
            line = site.arcl(f'queueQuery id {one["segmentId"]}')[0].split(' ')
            assert line[1:3] + line[3:6] == [one['segmentId'], job['jobId'], str(one['priority']),
                                             one['status'], one['subStatus']]
            assert line[7:9] == [f'"{one["goalName"]}"', f'"{one["robot"] or "None"}"']


@settings(max_examples=settings.default.max_examples)
@given(steps=st.lists(st.tuples(st.sampled_from((
    'rest', 'arcl', 'exchange', 'drive', 'reach', 'cancel', 'fail', 'modify')),
    st.integers(0, 5)), max_size=25))
def test_both_interfaces_tell_the_same_state_of_a_job(steps):
    site = Site()
    for act, number in steps:
        missions = [key for key, one in site.fleet.missions.items() if one.shown.state.is_open]
        if act == 'rest':
            site.made('/PickupDropoff', {'pickupGoal': 'x', 'dropoffGoal': 'y'})
        elif act == 'arcl':
            assert 'successfully queued' in site.arcl('queuePickup z')[0]
        elif act == 'exchange':
            site.exchange()
        elif act == 'cancel':
            site.post('/JobCancel', {'jobNamekey': f'JOB{number}', 'cancelReason': 'why'})
        elif act == 'modify':
            site.post('/JobSegmentModify', {'segmentId': f'PICKUP{number}', 'goal': 'y'})
        elif missions:
            key = missions[number % len(missions)]
            if act == 'fail':
                site.fleet.set(key, State.FAILED)
                site.server.announce(tell(site.book, key, site.fleet.missions[key].shown, site.now))
            elif act == 'drive' or site.fleet.missions[key].shown.state is State.ACTIVE:
                site.drive(list(site.fleet.missions).index(key), reach=act == 'reach')
        same_in_both(site)


def test_a_job_of_rest_is_told_to_clients_of_arcl():
    site = Site()
    site.made('/Pickup', {'goal': 'x', 'jobId': 'one'})
    assert site.client.output.decode().startswith(
        'QueueUpdate: PICKUP1 one 10 Pending None Goal "x" "None" ')


def test_requests_jobs_and_their_keys_outlive_a_restart():
    site = Site()
    made = site.made('/JobRequest', {'namekey': 'own', 'details': [{'pickupGoal': 'x'}]})
    site.exchange()
    site.drive()
    again = Site(site.disk, site.fleet, site.now + 5)
    shown = again.ask('/JobRequest/ByKey/own')
    assert (shown['details'], shown['assignedJobId']) == (made['details'], made['assignedJobId'])
    assert again.post('/JobRequest', {'namekey': 'own', 'details': [{'pickupGoal': 'x'}]}
                      ).status == 400
    assert len(again.book.jobs) == 1
    assert again.ask('/Job/UpdatedSince?sinceTime=1005000')  # the job counts as changed


def test_cancellations_and_modifications_outlive_a_restart_and_their_keys_count_once():
    site = Site()
    for goal in 'xyz':
        site.made('/Pickup', {'goal': goal})
    made = {}
    for path, record in (
            ('/JobCancel', {'namekey': 'own', 'jobId': 'JOB1', 'cancelReason': 'why'}),
            ('/JobCancel', {'jobId': 'JOB2'}),
            ('/JobSegmentModify', {'namekey': 'm', 'segmentId': 'PICKUP3', 'priority': 7}),
            ('/JobSegmentModify', {'segmentId': 'PICKUP3', 'goal': 'x'})):
        one = site.made(path, record)
        made[f'{path}/ByKey/{one["namekey"]}'] = one
    assert list(made) == ['/JobCancel/ByKey/own', '/JobCancel/ByKey/~2',
                          '/JobSegmentModify/ByKey/m', '/JobSegmentModify/ByKey/~2']
    again = Site(site.disk, site.fleet, site.now - 5)  # the clock was set back as well
    assert {path: again.ask(path) for path in made} == made
    assert again.post('/JobCancel', {'namekey': 'own', 'jobId': 'JOB3'}).status == 400
    assert again.book.jobs[2].cancel is None
    third = again.made('/JobCancel', {'jobId': 'JOB3'})
    assert third['namekey'] == '~3'
    since = made['/JobSegmentModify/ByKey/~2']['audit']['upd']['millis']
    assert third in again.ask(f'/JobCancel/UpdatedSince?sinceTime={since}')


def test_a_cancellation_that_cannot_be_stored_has_no_record():
    site = Site()
    site.made('/Pickup', {'goal': 'x'})
    site.disk.is_full = True
    assert site.post('/JobCancel', {'namekey': 'own', 'jobId': 'JOB1'}).status == 500
    site.disk.is_full = False
    assert site.get('/JobCancel/ByKey/own').status == 404
    assert site.made('/JobCancel', {'namekey': 'own', 'jobId': 'JOB1'})['status'] == 'Completed'


def test_the_oldest_cancellations_are_forgotten_and_no_key_made_here_comes_twice(monkeypatch):
    monkeypatch.setattr('omron_jobs.core.rest_records.MOST_POSTED', 3)
    site = Site()
    keys = [site.made('/JobCancel', {'robot': 'r1'})['namekey'] for _ in range(8)]
    assert keys == [f'~{number}' for number in range(1, 9)]
    kept = [one['namekey'] for one in site.ask('/JobCancel/UpdatedSince?sinceTime=0')]
    assert kept == keys[5:]


# -- bad input -------------------------------------------------------------------------------------


@pytest.mark.parametrize('path, body, status, words', [
    ('/JobRequest', b'', 400, 'no JSON'), ('/JobRequest', b'\xff', 400, 'no JSON'),
    ('/JobRequest', b'[' * 60000, 400, 'no JSON'), ('/JobRequest', b'[]', 400, 'no JSON object'),
    ('/JobRequest', b'{"details": NaN}', 400, 'no JSON'),
    ('/JobRequest', b'{"strange": 1}', 400, 'no field'),
    ('/JobRequest', b'{"details": []}', 400, 'list'), ('/JobRequest', b'{}', 400, 'list'),
    ('/JobRequest', b'{"details": [{}]}', 400, 'no goal'),
    ('/JobRequest', b'{"details": [3]}', 400, 'no JSON object'),
    ('/JobRequest', b'{"details": [{"goal": "x"}]}', 400, 'segmentType is missing'),
    ('/JobRequest', b'{"details": [{"goal": "x", "segmentType": "Fly"}]}', 400, 'segmentType must'),
    ('/JobRequest', b'{"details": [{"goal": "x", "pickupGoal": "x"}]}', 400, 'either'),
    ('/JobRequest', b'{"details": [' + b','.join([b'{"pickupGoal": "x"}'] * 51) + b']}', 400, '50'),
    ('/JobRequest', b'{"defaultPriority": 1, "details": [{"pickupGoal": "x"}]}', 400, 'true or'),
    ('/Pickup', b'{"goal": "nowhere"}', 400, 'no goal "nowhere"'),
    ('/Pickup', b'{"goal": 3}', 400, 'goal must be a text'),
    ('/Pickup', b'{"goal": "x", "priority": 2147483648}', 400, '32 bits'),
    ('/Pickup', b'{"goal": "x", "priority": "5"}', 400, '32 bits'),
    ('/Pickup', b'{"goal": "x", "priority": true}', 400, '32 bits'),
    ('/Pickup', b'{"goal": "x", "jobId": "a b"}', 400, 'no blanks'),
    ('/Pickup', b'{"goal": "x", "jobId": "a\\r\\nQueueUpdate:"}', 400, 'that print'),
    ('/Pickup', b'{"goal": "x", "jobId": "\\ud800"}', 400, 'that print'),
    ('/Pickup', b'{"goal": "x", "jobId": "' + b'a' * 128 + b'"}', 400, '127'),
    ('/Pickup', b'{"goal": "x", "namekey": "~1"}', 400, 'must not begin'),
    ('/Dropoff', b'{"goal": "x"}', 400, 'robot is missing'),
    ('/Dropoff', b'{"goal": "x", "robot": "r9"}', 400, 'no such robot'),
    ('/JobCancel', b'{}', 400, 'one way'),
    ('/JobCancel', b'{"robot": "r1", "jobId": "a"}', 400, 'one way'),
    ('/JobCancel', b'{"cancelType": "All", "cancelValue": "a"}', 400, 'cancelType must'),
    ('/JobCancel', b'{"cancelType": "Status", "cancelValue": "a"}', 400, 'cancelValue must'),
    ('/JobCancel', b'{"jobNamekey": "JOB7"}', 404, 'No active job'),
    ('/JobSegmentModify', b'{"segmentId": "PICKUP1"}', 400, 'either'),
    ('/JobSegmentModify', b'{"priority": 1}', 400, 'segmentNamekey is missing'),
    ('/Job', b'{}', 404, 'no such path'), ('/WaitTaskCancel', b'{}', 404, 'not offered'),
    ('/', b'{}', 404, 'no such path'), ('/JobRequest/own', b'{}', 404, 'no such path')])
def test_bad_input_is_answered_with_an_error_record_and_makes_no_job(path, body, status, words):
    site = Site()
    answer = site.api.answer('POST', path, {}, body)
    assert answer.status == status == answer.body['status']
    assert words in answer.body['message']
    assert not site.book.jobs and not site.disk.jobs


def test_nothing_is_queued_that_cannot_be_stored_or_has_no_goals_yet():
    site = Site()
    site.disk.is_full = True
    assert site.post('/Pickup', {'goal': 'x'}).status == 500
    site.disk.is_full, site.site.goals = False, None
    assert site.post('/Pickup', {'goal': 'x'}).status == 500
    assert not site.book.jobs


def test_a_job_id_of_an_active_job_is_refused():
    site = Site()
    site.made('/Pickup', {'goal': 'x', 'jobId': 'one'})
    answer = site.post('/Pickup', {'goal': 'x', 'jobId': 'ONE'})
    assert answer.status == 400 and 'active job' in answer.body['message']


NAMES = [*PATHS, 'WaitTaskCancel', 'DataStoreValueLatest', '', '%', '%ff']
FIELD = st.sampled_from((
    'namekey', 'jobId', 'defaultPriority', 'details', 'goal', 'priority', 'segmentType',
    'pickupGoal', 'dropoffGoal', 'robot', 'cancelType', 'cancelValue', 'cancelReason', 'segmentId',
    'jobNamekey', 'status', 'pickupPriority'))
VALUE = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
    | st.sampled_from(('x', 'y', 'r1', 'Pickup', 'PICKUP1', 'Status', 'Pending', 'JOB1')),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(FIELD, inner, max_size=4),
    max_leaves=8)


@settings(max_examples=settings.default.max_examples * 20 // 3)
@given(method=st.sampled_from(('GET', 'POST', 'PUT', 'DELETE', 'X')),
       parts=st.lists(st.sampled_from(NAMES) | st.sampled_from(
           ('ByKey', 'ByStatus', 'UpdatedSince', 'History', 'ByJob', 'By', 'ByActive', 'x'))
           | st.text(max_size=5), max_size=4),
       query=st.dictionaries(st.sampled_from(('sinceTime', 'namekey')), st.text(max_size=25)),
       body=st.binary(max_size=40) | st.dictionaries(FIELD, VALUE, max_size=5).map(
           lambda one: json.dumps(one).encode()))
def test_no_request_raises_and_only_an_answer_201_makes_a_job(method, parts, query, body):
    site = Site()
    site.arcl('queuePickup x')
    before, stored = site.book.jobs, dict(site.disk.jobs)
    answer = site.api.answer(method, '/' + '/'.join(parts), query, body)
    assert answer.status in (200, 201, 400, 404, 500)
    json.dumps(answer.body)
    if answer.status != 201:
        assert site.book.jobs == before and site.disk.jobs == stored
    else:
        assert method == 'POST' and len(site.book.jobs) <= 2
