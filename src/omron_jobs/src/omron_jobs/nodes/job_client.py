"""job_client: hands jobs of this workspace to an OMRON Fleet Manager, over ARCL.

Actions
    ~queue_job (omron_ld90_msgs/QueueJob): queues or modifies a job; ends with the job
Publishes
    ~job_status (omron_ld90_msgs/JobStatus): at each change of a job; at the start for each open job
    /diagnostics
Parameters
    ~fleet_manager_ip  string  (required)  address or name of the Fleet Manager
    ~port              int     7171        its ARCL port
    ~password_file     string  (required)  contains its ARCL password, and nothing else
    ~jobs_file         string  omron_jobs/handed_jobs.json  keeps the jobs; a relative path begins
                                           in ROS_HOME
"""
from __future__ import annotations

import secrets
import threading
import time
from typing import Dict, Iterable, List, Tuple

import actionlib
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from node_lifecycle import parameter, publish_diagnostics, run, warn
from node_lifecycle.secret_files import read_password_file
from omron_jobs.client.fleet_manager_lines import WrongJob
from omron_jobs.client.handed_jobs import HandedJob, HandedState, HandedStop, HandedStopKind
from omron_jobs.client.job_client import JobClient, TooManyJobs
from omron_jobs.network.job_handover import JobHandover
from omron_jobs.nodes.handed_jobs_file import HandedJobsFile
from omron_ld90_msgs.msg import (
    JobStatus,
    JobStop,
    QueueJobAction,
    QueueJobFeedback,
    QueueJobGoal,
    QueueJobResult,
)

_NAME = 'job_client'
_KINDS = {JobStop.PICKUP: HandedStopKind.PICKUP, JobStop.DROPOFF: HandedStopKind.DROPOFF}


class JobClientNode:
    """The node that the module describes. One lock guards the jobs and the action goals."""

    def __init__(self) -> None:
        host, port = parameter('~fleet_manager_ip'), parameter('~port', 7171, int)
        password = read_password_file(parameter('~password_file'), 'password of the Fleet Manager')
        self._file = HandedJobsFile(parameter('~jobs_file', 'omron_jobs/handed_jobs.json'),
                                    '~jobs_file')
        jobs = JobClient(self._file.read(), self._file.write, lambda: int(time.time() * 1000),
                         lambda: f'ROS{secrets.token_hex(8)}')
        self._lock = threading.RLock()
        self._handover = JobHandover(jobs, host, port, password, self._on_change, lock=self._lock)
        self._goals: Dict[str, List[actionlib.ServerGoalHandle]] = {}
        self._status = rospy.Publisher('~job_status', JobStatus, queue_size=1000)
        self._server = actionlib.ActionServer('~queue_job', QueueJobAction, self._on_goal,
                                              self._on_cancel, auto_start=False)
        for job in self._handover.jobs:
            if job.is_open:
                self._status.publish(status_of(job))
        publish_diagnostics('none', {'jobs': self._show})
        rospy.on_shutdown(self._handover.close)
        self._handover.start()
        self._server.start()

    def _on_goal(self, goal: actionlib.ServerGoalHandle) -> None:
        with self._lock:
            try:
                wanted = goal.get_goal()
                stops = stops_of(wanted.stops)
                job = (self._handover.modify(wanted.request_id, stops) if wanted.modifies
                       else self._handover.request(stops, wanted.request_id))
            except (WrongJob, TooManyJobs) as problem:
                goal.set_rejected(text=f'{_refusal(wanted)}: {problem}.')
                return
            except OSError as problem:
                goal.set_rejected(text=f'{_refusal(wanted)}, this cannot be stored: {problem}.')
                return
            goal.set_accepted()
            self._goals.setdefault(job.id, []).append(goal)
            goal.publish_feedback(QueueJobFeedback(status_of(job)))
            if not job.is_open:
                self._end(job)

    def _on_cancel(self, goal: actionlib.ServerGoalHandle) -> None:
        with self._lock:
            id = next((id for id, goals in self._goals.items() if goal in goals), None)
            if id is None:
                return
            try:
                self._handover.cancel(id)
            except OSError as problem:
                warn('cancel', f'Job {id} is not cancelled, this cannot be stored ({problem}): '
                               'cancel it again.')

    def _on_change(self, job: HandedJob) -> None:
        status = status_of(job)
        self._status.publish(status)
        for goal in self._goals.get(job.id, []):
            goal.publish_feedback(QueueJobFeedback(status))
        if not job.is_open:
            self._end(job)

    def _end(self, job: HandedJob) -> None:
        result = QueueJobResult(status_of(job))
        for goal in self._goals.pop(job.id, []):
            if job.state is HandedState.COMPLETED:
                goal.set_succeeded(result)
            elif job.state is HandedState.CANCELLED and job.is_unwanted:
                goal.set_canceled(result)
            else:
                goal.set_aborted(result, f'The job ended as {job.state.name}. {job.reason}'.strip())

    def _show(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        link = self._handover.link
        if self._handover.problem:
            status.summary(DiagnosticStatus.ERROR, self._handover.problem)
        elif not link.connected:
            status.summary(DiagnosticStatus.WARN, f'no link to {link.peer}: {link.reason}')
        else:
            status.summary(DiagnosticStatus.OK, f'linked to {link.peer}')
        status.add('open jobs', str(sum(job.is_open for job in self._handover.jobs)))
        return status


def _refusal(wanted: QueueJobGoal) -> str:
    return f'The job is not {"modified" if wanted.modifies else "queued"}'


def stops_of(stops: Iterable[JobStop]) -> Tuple[HandedStop, ...]:
    """Returns the stops of a message. Raises WrongJob."""
    found: List[HandedStop] = []
    for stop in stops:
        if stop.kind not in _KINDS:
            raise WrongJob(f'kind {stop.kind} is neither PICKUP nor DROPOFF')
        found.append(HandedStop(stop.goal, _KINDS[stop.kind],
                                stop.priority if stop.has_priority else None))
    return tuple(found)


def status_of(job: HandedJob) -> JobStatus:
    """Returns the message about a job."""
    status = JobStatus(job_id=job.id, request_id=job.request, state=int(job.state),
                       segment_ids=[one.id for one in job.segments],
                       segment_states=[one.status for one in job.segments],
                       segment_goals=[one.goal for one in job.segments],
                       segment_priorities=[one.priority for one in job.segments], robot=job.robot,
                       reason=job.reason, modification=int(job.modification),
                       linked_job_id=job.linked)
    status.header.stamp = rospy.Time.now()
    return status


def main() -> None:
    """Runs the node."""
    run(_NAME, JobClientNode)
