"""job_server: accepts jobs from warehouse programs, as OMRON's Fleet Manager does.

The jobs come over ARCL, or over REST as in FLOW Core's Integration Toolkit. Each job is a mission
of the fleet manager.

Subscribes
    /graph (itrci_nav_msgs/Graph), /fleet_state (itrci_nav_msgs/FleetState): latched
    /mission_status (itrci_nav_msgs/MissionStatus)
Publishes
    /mission_request (itrci_nav_msgs/MissionRequest)
    /mission_command (itrci_nav_msgs/MissionCommand)
    /diagnostics
Calls
    /get_mission_status (itrci_nav_msgs/GetMissionStatus), if a mission has no news for long
Parameters
    ~password_file  string  (required)  contains the password of the clients, and nothing else
    ~host           string  127.0.0.1   the address on which clients may connect
    ~port           int     7171
    ~peers          string  ''          addresses and networks of clients on other computers,
                                        separated by commas
    ~jobs_file      string  omron_jobs/jobs.sqlite  keeps the jobs; a relative path begins in
                                        ROS_HOME
    ~outgoing_host  string  ''          a program to which this node connects by itself; empty: none
    ~outgoing_port  int     7179
    ~outgoing_commands string  ''       commands that are repeated for that program, separated by |
    ~outgoing_seconds float  0.0        s between two repetitions; 0: never
    ~robot_type     string  ''          robots that serve jobs; empty: all
    ~work_file      string  ''          work file (YAML), for the steps at the goals of jobs
    ~rest_port      int     0           port of the REST interface; 0: there is no such interface
    ~rest_host      string  127.0.0.1   the address on which REST clients may connect
    ~rest_password_file  string  ''     contains the password of REST clients, and nothing else
    ~rest_certificate, ~rest_key  string  ''  PEM files; with them the REST interface uses TLS
"""
from __future__ import annotations

import asyncio
import queue
import random
import ssl
import time
from functools import partial
from typing import Any, Callable, Dict, NamedTuple, Optional, Set, Tuple

import genpy
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from browser_guard.certificates import WrongCertificate, certificates_of
from fleet_core.files.errors import FileError
from fleet_core.files.work_file import load_work
from fleet_core.work.site_work import SiteWork
from fleet_requests import Sender, mission_request, stored_status
from graph_fleet_manager.messages.stops import stop_messages
from graph_topic import FollowedGraph
from itrci_nav_msgs.msg import FleetState, MissionCommand, MissionRequest, MissionStatus
from node_lifecycle import (
    ConfigurationError,
    number,
    parameter,
    publish_diagnostics,
    run,
    warn,
)
from node_lifecycle.secret_files import read_password_file
from node_lifecycle.worker import start_worker
from omron_jobs.core.client_session import JobServer
from omron_jobs.core.job_book import FleetAct, FleetMessage, JobBook
from omron_jobs.core.job_commands import JobCommands, JobSite
from omron_jobs.core.job_words import SegmentStatus
from omron_jobs.core.jobs import QueuedJob
from omron_jobs.core.rest_api import RestApi
from omron_jobs.core.rest_records import RestRecords
from omron_jobs.fleet.missions import goals_of, stops_of
from omron_jobs.network.job_port import JobPort, WrongPeer, read_peers
from omron_jobs.network.outgoing_link import DialledAddress, DialledLink
from omron_jobs.network.rest_port import RestPort
from omron_jobs.nodes.fleet_news import (
    WrongStatus,
    drives_of,
    mission_of,
    robots_of,
    stamp_of,
)
from omron_jobs.nodes.job_file import JobFile
from trajectory_graph import Graph

TICK = 0.2          # s between two checks for work that is due
SHORTEST_PERIOD = 0.1  # s between two repetitions of the outgoing commands
_NAME = 'job_server'


class JobServerNode:
    """The node that the module describes. One thread owns the jobs and the clients.

    It has many attributes because one thread serves its topics, ports, files and records.
    """

    def __init__(self) -> None:
        password = read_password_file(parameter('~password_file'), 'password of the job server')
        self._robot_type = parameter('~robot_type', '')
        self._work_path = parameter('~work_file', '')
        self._site_work: Optional[SiteWork] = None  # None: it is not known yet
        self._jobs_file = JobFile(parameter('~jobs_file', 'omron_jobs/jobs.sqlite'), '~jobs_file')
        ids = random.SystemRandom()
        jobs, counters = self._jobs_file.read()
        self._book = JobBook(jobs, counters, self._jobs_file, lambda: int(time.time() * 1000),
                             lambda: ids.randint(1, 2 ** 31 - 1))
        self._site = JobSite()
        self._server = JobServer(JobCommands(self._book, self._site), password)
        self._port = JobPort(self._server, peers(), self._work_soon)
        self._records = RestRecords(self._book, self._site, lambda: int(time.time() * 1000),
                                    self._jobs_file.read_posted())
        self._server.on_changes = self._records.announce
        self._problem = self._work_problem = ''
        self._works_soon = False
        self._questions: queue.Queue[Tuple[QueuedJob, float]] = queue.Queue()
        self._asked: Set[int] = set()  # missions with a question that has no answer yet
        self._loop = asyncio.new_event_loop()
        self._outgoing, rest = outgoing_link(self._port), rest_settings()
        self._rest_port: Optional[RestPort] = None
        try:
            self.port = self._listen(parameter('~host', '127.0.0.1'), parameter('~port', 7171, int))
            if rest is not None:
                self._rest_port = self._open_rest(rest)
        except ConfigurationError:
            self._port.close()  # clients must not wait for a node that does not work
            raise
        self._requests, self._commands = Sender(MissionRequest), Sender(MissionCommand)
        publish_diagnostics('none', {'jobs': self._show})
        rospy.on_shutdown(self._end)
        start_worker('questions', self._ask)
        start_worker('jobs', self._run)
        FollowedGraph(self._on_graph).subscribe()
        rospy.Subscriber('/fleet_state', FleetState, self._on_state, queue_size=1)
        rospy.Subscriber('/mission_status', MissionStatus, self._on_status, queue_size=10_000,
                         tcp_nodelay=True)

    def _listen(self, host: str, port: int) -> int:
        try:
            return self._loop.run_until_complete(self._port.open(host, port))
        except (OSError, OverflowError) as error:
            raise ConfigurationError(f'Port {port} of {host} cannot be listened on ({error}): free '
                                     'it, or set ~host and ~port.') from None

    def _open_rest(self, settings: RestSettings) -> RestPort:
        port = RestPort(RestApi(self._book, self._site, self._records, self._server.announce),
                        self._records, settings.password, self._port.peers, self._work_soon)
        try:
            self._loop.run_until_complete(
                port.open(settings.host, settings.port, settings.certificates))
        except (OSError, OverflowError) as error:
            raise ConfigurationError(
                f'Port {settings.port} of {settings.host} cannot be listened on ({error}): free '
                'it, or set ~rest_host and ~rest_port.') from None
        return port

    # --- callbacks --------------------------------------------------------------------------------

    def _on_graph(self, graph: Graph, _stamp: rospy.Time) -> None:
        goals: Optional[Dict[str, int]] = goals_of(graph.vertices.values())
        work: Optional[SiteWork] = None
        self._work_problem = ''
        try:
            work = load_work(self._work_path, graph) if self._work_path else SiteWork()
        except FileError as error:
            goals = None
            self._work_problem = (f'no jobs are taken: {str(error).rstrip(".")}. Mend the file, '
                                  'and start this node again')
            warn('work', self._work_problem)

        def put() -> None:
            self._site.goals, self._site_work = goals, work
            self._work_soon()
        self._put(put)

    def _on_state(self, message: FleetState) -> None:
        def put() -> None:
            self._server.announce(self._book.hear_drives(drives_of(message)))
            self._site.robots = robots_of(message, self._substatus)
            self._work_soon()
        self._put(put)

    def _on_status(self, message: MissionStatus) -> None:
        self._put(lambda: self._hear(message))

    def _put(self, call: Callable[[], Any]) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(call)

    def _ask(self) -> None:
        """Asks the fleet manager for the status of silent missions, one after the other."""
        while True:
            job, asked = self._questions.get()
            self._put(partial(self._hear_answer, job, asked,
                              stored_status(job.mission, stamp(job))))

    # --- in the thread that owns the jobs ---------------------------------------------------------

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.call_soon(self._tick)
        if self._outgoing is not None:
            self._loop.call_soon(self._outgoing.start)
        self._loop.run_forever()

    def _tick(self) -> None:
        self._loop.call_later(TICK, self._tick)
        for message in self._book.silent(time.monotonic()):
            self._send(message)
        self._work_soon()
        try:
            self._book.store_news()
            self._problem = ''
        except OSError as error:
            self._problem = f'jobs cannot be stored: {error.strerror}'

    def _hear(self, message: MissionStatus) -> None:
        try:
            news = mission_of(message)
        except WrongStatus as wrong:
            warn('status', f'A status is ignored: {wrong}.')
            return
        self._server.announce(self._book.hear(message.request_id, stamp_of(message), news,
                                          time.monotonic()))
        self._work_soon()

    def _hear_answer(self, job: QueuedJob, asked: float, answer: Any) -> None:
        self._asked.discard(job.mission)
        if answer is None:  # the fleet manager restarts: the question is repeated
            return
        if answer.found:
            self._hear(answer.status)
        else:
            self._server.announce(self._book.hear_unknown(job.mission, job.queued, asked))
            self._work_soon()

    def _work_soon(self) -> None:
        """Schedules `_work` once for all inputs that are waiting, because many statuses may come at
        once.
        """
        if not self._works_soon:
            self._works_soon = True
            self._loop.call_soon(self._work)

    def _work(self) -> None:
        """Sends lines to clients and messages to the fleet manager, and updates the records."""
        self._works_soon = False
        self._port.flush()
        if self._requests.is_heard and self._commands.is_heard:
            for message in self._book.due(time.monotonic()):
                self._send(message)
        self._records.refresh()

    def _send(self, message: FleetMessage) -> None:
        act, job, first = message
        if act in (FleetAct.REQUEST, FleetAct.CHANGE) and self._site_work is None:
            return  # the steps at the stops are not known yet: the message is repeated
        stops = stop_messages(stops_of(job, self._site_work or SiteWork()))
        if act is FleetAct.REQUEST:
            request = mission_request((), request_id=job.mission, stops=stops,
                                      priority=job.segments[0].priority, requested_by=_NAME,
                                      robot_type=self._robot_type, robot=job.robot)
            request.header.stamp = stamp(job)
            self._requests.repeat(request)
        elif act is FleetAct.ASK:
            if job.mission not in self._asked:
                self._asked.add(job.mission)
                self._questions.put((job, time.monotonic()))
        else:
            command = MissionCommand(
                request_id=job.mission, requested_by=_NAME, priority=job.segments[0].priority,
                command=MissionCommand.CANCEL if act is FleetAct.CANCEL else MissionCommand.MODIFY,
                first_stop=first, stops=stops[first - 1:] if first else [])
            command.header.stamp = rospy.Time.now()
            self._commands.repeat(command)

    def _substatus(self, mission: int) -> Optional[str]:
        job = self._book.shelf.get(mission)
        current = None if job is None else job.current
        return (current.told.substatus if current is not None
                and current.told.status is SegmentStatus.IN_PROGRESS else None)

    def _show(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        if self._problem or self._work_problem:
            status.summary(DiagnosticStatus.ERROR, self._problem or self._work_problem)
        elif not self._requests.is_heard:
            status.summary(DiagnosticStatus.WARN, self._requests.complaint)
        elif self._outgoing is not None and self._outgoing.trouble:
            status.summary(DiagnosticStatus.WARN,
                           f'the outgoing connection is lost: {self._outgoing.trouble}')
        else:
            status.summary(DiagnosticStatus.OK, f'{len(self._server.sessions)} clients')
        status.add('active jobs', str(len(self._book.shelf.open_ids)))
        return status

    def _end(self) -> None:
        def end() -> None:
            if self._outgoing is not None:
                self._outgoing.close()
            self._port.close()
            if self._rest_port is not None:
                self._rest_port.close()
            self._loop.stop()
        self._put(end)


def stamp(job: QueuedJob) -> genpy.Time:
    """Returns the stamp of the request for a job's mission. A later request with another stamp may
    have the same id.
    """
    return genpy.Time(job.queued // 1000, job.queued % 1000 * 1_000_000)


def peers() -> Any:
    """Returns the networks of ~peers. Raises ConfigurationError."""
    try:
        return read_peers(parameter('~peers', ''))
    except WrongPeer as wrong:
        raise ConfigurationError(f'Parameter {rospy.resolve_name("~peers")}: {wrong}.') from None


def outgoing_link(port: JobPort) -> Optional[DialledLink]:
    """Returns the outgoing connection; None: ~outgoing_host is empty.

    Raises ConfigurationError.
    """
    host, number_of_port = parameter('~outgoing_host', ''), parameter('~outgoing_port', 7179, int)
    commands = parameter('~outgoing_commands', '').split('|')
    seconds = number('~outgoing_seconds', 0.0, 0.0, 86_400.0)
    if not host:
        return None
    if not 0 < number_of_port < 65536:
        raise ConfigurationError(f'Parameter {rospy.resolve_name("~outgoing_port")} is '
                                 f'{number_of_port}: give a number from 1 to 65535.')
    if seconds and seconds < SHORTEST_PERIOD:
        raise ConfigurationError(f'Parameter {rospy.resolve_name("~outgoing_seconds")} is '
                                 f'{seconds}: give 0, or at least {SHORTEST_PERIOD} s.')
    return DialledLink(port, DialledAddress(
        host, number_of_port, tuple(one.strip() for one in commands if one.strip()), seconds))


class RestSettings(NamedTuple):
    """The settings of the REST interface. `certificates` is None without TLS."""

    host: str
    port: int
    password: bytes
    certificates: Optional[ssl.SSLContext]


def rest_settings() -> Optional[RestSettings]:
    """Returns the settings of the REST interface; None: there is none.

    Raises ConfigurationError.
    """
    port = parameter('~rest_port', 0, int)
    host, file = parameter('~rest_host', '127.0.0.1'), parameter('~rest_password_file', '')
    certificate, key = parameter('~rest_certificate', ''), parameter('~rest_key', '')
    if not port:
        return None
    if not file:
        raise ConfigurationError('The REST interface needs ~rest_password_file.')
    if not certificate and host not in ('127.0.0.1', '::1', 'localhost'):
        raise ConfigurationError(f'The REST interface would send its password unencrypted to '
                                 f'{host}: set ~rest_certificate and ~rest_key.')
    password = read_password_file(file, 'password of the REST interface')
    try:
        certificates = certificates_of(certificate, key) if certificate else None
    except WrongCertificate as wrong:
        raise ConfigurationError(str(wrong)) from None
    return RestSettings(host, port, password, certificates)


def main() -> None:
    """Runs the node."""
    run(_NAME, JobServerNode)
