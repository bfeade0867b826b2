"""The node of the client: the feedback to callers of its action, and its file."""
from __future__ import annotations

import json
from dataclasses import replace
from typing import Any, Callable, Dict, Iterator, List

import actionlib
import pytest
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from node_lifecycle import ConfigurationError
from omron_arcl import Link, LinkPhase
from omron_jobs.client.fleet_manager_lines import WrongJob
from omron_jobs.client.handed_jobs import (
    HandedEvent,
    HandedJob,
    HandedSegment,
    HandedStop,
    HandedStopKind,
)
from omron_jobs.nodes import job_client
from omron_jobs.nodes.handed_jobs_file import HandedJobsFile
from omron_jobs.nodes.job_client import JobClientNode, status_of, stops_of
from omron_ld90_msgs.msg import JobStatus, JobStop, QueueJobGoal

STOPS = (HandedStop('x', HandedStopKind.PICKUP), HandedStop('y', HandedStopKind.DROPOFF, 7))
MESSAGE = [JobStop(goal='x', kind=JobStop.PICKUP),
           JobStop(goal='y', kind=JobStop.DROPOFF, has_priority=True, priority=7)]
ENDS = {HandedEvent.COMPLETED: 'succeeded', HandedEvent.CANCELLED: 'aborted',
        HandedEvent.FAILED: 'aborted'}


class Handover:
    """Keeps jobs without a link; the test changes their states."""

    def __init__(self, jobs: Any, host: str, port: int, password: bytes,
                 on_change: Callable[[HandedJob], None], lock: Any) -> None:
        self.address, self.password = (host, port), password
        self._jobs, self._on_change = jobs, on_change
        self.link = Link(LinkPhase.DISCONNECTED, f'{host}:{port}', 'not started')
        self.problem, self.cancelled = '', []
        self.fails = False

    def start(self) -> None:
        self.link = Link(LinkPhase.CONNECTED, self.link.peer)

    def close(self) -> None:
        """Does nothing."""

    @property
    def jobs(self) -> List[HandedJob]:
        return self._jobs.jobs

    def request(self, stops: Any, request: str) -> HandedJob:
        if self.fails:
            raise OSError(28, 'No space left on device')
        return self._jobs.request(stops, request)

    def modify(self, request: str, stops: Any) -> HandedJob:
        if self.fails:
            raise OSError(28, 'No space left on device')
        return self._jobs.modify(request, stops)

    def cancel(self, id: str) -> None:
        if self.fails:
            raise OSError(28, 'No space left on device')
        self.cancelled.append(id)
        self._jobs.cancel(id)

    def change(self, id: str, *events: HandedEvent) -> None:
        job = next(job for job in self.jobs if job.id == id)
        for event in events:
            job = job.after(event)
        self._jobs._put(job)
        for changed in self._jobs.pop_changes():
            self._on_change(changed)


class Goal:
    """A goal of the action, with the states and feedback that its caller gets."""

    def __init__(self, stops: List[JobStop], request: str = '', modifies: bool = False) -> None:
        self._goal = QueueJobGoal(request_id=request, stops=stops, modifies=modifies)
        self.told: List[str] = []
        self.states: List[int] = []
        self.statuses: List[JobStatus] = []
        self.text = ''

    def get_goal(self) -> QueueJobGoal:
        return self._goal

    def publish_feedback(self, feedback: Any) -> None:
        self.states.append(feedback.status.state)
        self.statuses.append(feedback.status)

    def set_accepted(self) -> None:
        self.told.append('accepted')

    def set_rejected(self, text: str) -> None:
        self.told.append('rejected')
        self.text = text

    def set_succeeded(self, result: Any) -> None:
        self.told.append('succeeded')

    def set_canceled(self, result: Any) -> None:
        self.told.append('canceled')

    def set_aborted(self, result: Any, text: str) -> None:
        self.told.append('aborted')
        self.text = text


class Topic:
    """A publisher that keeps its messages."""

    messages: List[JobStatus] = []

    def __init__(self, *_: object, **__: object) -> None:
        self.messages.clear()

    def publish(self, message: JobStatus) -> None:
        self.messages.append(message)


class Server:
    """An action server without topics."""

    def __init__(self, name: str, of: object, on_goal: Callable[[Goal], None],
                 on_cancel: Callable[[Goal], None], auto_start: bool) -> None:
        assert not auto_start
        self.on_goal, self.on_cancel = on_goal, on_cancel

    def start(self) -> None:
        """Does nothing."""


@pytest.fixture
def parameters(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> Iterator[Dict[str, object]]:
    (tmp_path / 'password').write_text('secret\n')
    (tmp_path / 'password').chmod(0o600)
    found: Dict[str, object] = {'~fleet_manager_ip': '127.0.0.1',
                                '~password_file': str(tmp_path / 'password'),
                                '~jobs_file': str(tmp_path / 'jobs.json')}
    monkeypatch.setattr(job_client, 'parameter',
                        lambda name, default=None, kind=str: found.get(name, default))
    monkeypatch.setattr(job_client, 'publish_diagnostics', lambda *_: None)
    monkeypatch.setattr(job_client, 'JobHandover', Handover)
    monkeypatch.setattr(rospy, 'Publisher', Topic)
    monkeypatch.setattr(rospy, 'on_shutdown', lambda call: None)
    monkeypatch.setattr(rospy.Time, 'now', lambda: rospy.Time(5))
    monkeypatch.setattr(actionlib, 'ActionServer', Server)
    yield found


def ask(node: JobClientNode, stops: List[JobStop], request: str = '',
        modifies: bool = False) -> Goal:
    goal = Goal(stops, request, modifies)
    node._server.on_goal(goal)
    return goal


def test_a_job_is_accepted_when_it_is_on_the_disk(parameters):
    node = JobClientNode()
    assert node._handover.password == b'secret' and node._handover.address == ('127.0.0.1', 7171)
    goal = ask(node, MESSAGE, 'pallet 7')
    assert (goal.told, goal.states) == (['accepted'], [JobStatus.STORED])
    with open(str(parameters['~jobs_file']), encoding='utf-8') as file:
        stored, = json.load(file)
    assert stored['request'] == 'pallet 7'


@pytest.mark.parametrize('event', ENDS)
def test_the_end_of_a_job_is_the_result_of_each_goal_for_it(parameters, event):
    node = JobClientNode()
    goals = [ask(node, MESSAGE, 'pallet 7') for _ in range(2)]
    id = node._handover.jobs[0].id
    node._handover.change(id, HandedEvent.SENDING)
    node._handover.change(id, event)
    for goal in goals:
        assert goal.told == ['accepted', ENDS[event]]
        assert goal.states[:2] == [JobStatus.STORED, JobStatus.SENT]
    late = ask(node, MESSAGE, 'pallet 7')
    assert late.told == ['accepted', ENDS[event]]
    assert node._status.messages[-1].job_id == id


def test_a_goal_that_its_caller_cancels_ends_as_cancelled_and_others_do_not(parameters):
    node = JobClientNode()
    goal, other = ask(node, MESSAGE), ask(node, MESSAGE)
    id = node._handover.jobs[0].id
    node._handover.change(id, HandedEvent.SENDING)
    node._server.on_cancel(goal)
    node._server.on_cancel(Goal(MESSAGE))       # a goal that was rejected has no job
    assert node._handover.cancelled == [id]
    node._handover.change(id, HandedEvent.CANCELLED)
    assert goal.told == ['accepted', 'canceled'] and other.told == ['accepted']


def test_a_cancellation_that_cannot_be_stored_is_told(parameters, monkeypatch):
    warned: List[str] = []
    monkeypatch.setattr(job_client, 'warn', lambda key, text: warned.append(text))
    node = JobClientNode()
    goal = ask(node, MESSAGE)
    node._handover.fails = True
    node._server.on_cancel(goal)
    assert 'cancel it again' in warned[0] and goal.told == ['accepted']


@pytest.mark.parametrize('stops, words', [
    ([], '0 goals'), ([JobStop(goal='x', kind=9)], 'kind 9'),
    ([JobStop(goal='y', kind=JobStop.DROPOFF)], 'no pickup'),
    ([JobStop(goal='x"; quit', kind=JobStop.PICKUP)], 'no name of a goal')])
def test_a_wrong_job_is_rejected_with_its_reason(parameters, stops, words):
    goal = ask(JobClientNode(), stops)
    assert goal.told == ['rejected'] and words in goal.text


def test_a_job_that_cannot_be_stored_is_rejected(parameters):
    node = JobClientNode()
    node._handover.fails = True
    goal = ask(node, MESSAGE)
    assert goal.told == ['rejected'] and 'No space left' in goal.text


def test_a_goal_that_modifies_is_about_the_job_of_its_request(parameters):
    node = JobClientNode()
    first = ask(node, MESSAGE, 'pallet 7')
    id = node._handover.jobs[0].id
    node._handover.change(id, HandedEvent.SENDING, HandedEvent.ACCEPTED)
    other = [JobStop(goal='z', kind=JobStop.PICKUP), MESSAGE[1]]
    goal = ask(node, other, 'pallet 7', modifies=True)
    assert goal.told == ['accepted'] and goal.statuses[0].job_id == id
    assert goal.statuses[0].modification == JobStatus.MODIFYING
    node._handover.change(id, HandedEvent.COMPLETED)
    for one in (first, goal):
        assert one.told == ['accepted', 'succeeded']
        assert one.statuses[-1].modification == JobStatus.MODIFICATION_REFUSED
    late = ask(node, MESSAGE, 'pallet 7', modifies=True)
    assert late.told == ['accepted', 'succeeded']       # the job has these goals already
    late = ask(node, other, 'pallet 7', modifies=True)
    assert late.told == ['rejected'] and late.text == (
        'The job is not modified: its job has ended, or is cancelled.')
    node._handover.fails = True
    assert 'cannot be stored' in ask(node, MESSAGE, 'pallet 8', modifies=True).text


def test_a_status_says_what_the_fleet_manager_shows(parameters):
    segments = (HandedSegment('PICKUP1', 'Completed', 'x', 10),
                HandedSegment('DROPOFF2', 'InProgress', 'z', 5))
    status = status_of(replace(HandedJob('ROS1', STOPS), segments=segments, linked='JOB7'))
    assert status.segment_goals == ['x', 'z'] and status.segment_priorities == [10, 5]
    assert status.segment_states == ['Completed', 'InProgress'] and status.linked_job_id == 'JOB7'


def test_a_start_tells_the_open_jobs_of_the_last_one(parameters, tmp_path):
    ended = HandedJob('ROS2', STOPS).after(HandedEvent.WITHDRAWN)
    HandedJobsFile(str(tmp_path / 'before.json'), '~jobs_file').write(
        [HandedJob('ROS1', STOPS, 'pallet 7'), ended])
    (tmp_path / 'jobs.json').write_bytes((tmp_path / 'before.json').read_bytes())
    node = JobClientNode()
    assert [told.job_id for told in node._status.messages] == ['ROS1']
    ask(node, MESSAGE, 'pallet 7')
    assert [job.id for job in node._handover.jobs] == ['ROS1', 'ROS2']


@pytest.mark.parametrize('problem, linked, level, words', [
    ('', True, DiagnosticStatus.OK, 'linked to 127.0.0.1:7171'),
    ('', False, DiagnosticStatus.WARN, 'no link to 127.0.0.1:7171: refused'),
    ('jobs cannot be stored', True, DiagnosticStatus.ERROR, 'jobs cannot be stored')])
def test_diagnostics_say_why_no_job_is_handed_over(parameters, problem, linked, level, words):
    node = JobClientNode()
    ask(node, MESSAGE)
    node._handover.problem = problem
    if not linked:
        node._handover.link = Link(LinkPhase.DISCONNECTED, '127.0.0.1:7171', 'refused')
    status = node._show(DiagnosticStatusWrapper())
    assert (status.level, status.message) == (level, words)
    assert [(one.key, one.value) for one in status.values] == [('open jobs', '1')]


def test_a_file_of_jobs_that_cannot_be_read_is_an_error_and_is_kept(tmp_path):
    (tmp_path / 'jobs.json').write_text('[{"id": "ROS1"')
    with pytest.raises(ConfigurationError, match='mend the file'):
        HandedJobsFile(str(tmp_path / 'jobs.json'), '~jobs_file').read()
    assert (tmp_path / 'jobs.json').read_text() == '[{"id": "ROS1"'
    with pytest.raises(ConfigurationError, match='~jobs_file'):
        HandedJobsFile('', '~jobs_file')


def test_the_stops_of_a_message_are_those_of_the_job():
    assert stops_of(MESSAGE) == STOPS
    with pytest.raises(WrongJob):
        stops_of([JobStop(goal='x', kind=2)])
