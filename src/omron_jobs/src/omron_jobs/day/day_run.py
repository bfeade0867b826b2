"""Plays a day of jobs in virtual time: a program, the job server, and the fleet.

The job server consists of classes of the node: `JobServer`, `JobCommands` and `JobBook`. Its disk
is simulated. The program is logged in, sends each line at its time, and reads all lines of the
server.
The day is over when all jobs have ended, or `LONGEST_REST` after its last line.
"""
from __future__ import annotations

from random import Random
from typing import Dict, List, NamedTuple, Optional, Sequence

from fleet_simulation.site import StudiedSite
from fleet_simulation.studied_fleet import StudiedFleet
from omron_jobs.core.client_session import ClientPhase, ClientSession, JobServer
from omron_jobs.core.job_book import JobBook, JobCounters
from omron_jobs.core.job_commands import JobCommands, JobSite
from omron_jobs.core.jobs import QueuedJob
from omron_jobs.core.posted_records import PostedRecord
from omron_jobs.day.day_file import RESTART, DayLine
from omron_jobs.day.fleet_desk import FleetDesk
from omron_jobs.day.judge import GoalPlace, Judge, WatchedJob
from omron_jobs.fleet.missions import goals_of

TICK = 0.5              # s between two checks of the robots and of the messages that are due
LONGEST_REST = 7200.0   # s from the last line to the end of the day, at most
_UPDATE = 'QueueUpdate: '
_MINUTE = 60.0


class DayError(NamedTuple):
    """A command that was refused. `reply`: the line that its program got."""

    line: DayLine
    reply: str


class PlayedDay(NamedTuple):
    """A day that was played. Times of jobs are in s of the virtual clock.

    begin  -- s after midnight at which the virtual clock began
    hours  -- time from the first line to the end
    wrong  -- the broken promises, in sentences
    """

    begin: float
    hours: float
    robots: int
    jobs: Sequence[WatchedJob]
    refused: Sequence[DayError]
    wrong: Sequence[str]


class MemoryDisk:
    """Keeps the jobs across restarts of the job server.

    `missions` also contains the jobs that the job server has forgotten.
    """

    def __init__(self) -> None:
        self.jobs: Dict[int, QueuedJob] = {}
        self.counters = JobCounters()
        self.missions: Dict[str, int] = {}
        """The mission of each job, by the id of its first segment."""

    def write(self, jobs: Sequence[QueuedJob], forgotten: Sequence[int], counters: JobCounters,
              posted: Optional[PostedRecord] = None) -> None:
        """Stores jobs and counters. `posted` is always None, because a day has no REST clients."""
        for job in jobs:
            self.jobs[job.mission] = job
            self.missions[job.segments[0].id] = job.mission
        for id in forgotten:
            del self.jobs[id]
        self.counters = counters


class DayRun:
    """One day on a site. Each run with the same seed is the same.

    It has many attributes because it joins job server, fleet, program and judge.
    """

    def __init__(self, site: StudiedSite, robots: int, seed: int, lines: Sequence[DayLine]) -> None:
        self._lines = lines
        self._begin = _MINUTE * (lines[0].at // _MINUTE)
        random = Random(f'day {seed}')
        self._fleet = StudiedFleet(site, robots, seed, random)
        self._desk = FleetDesk(self._fleet, site.work)
        self._world = self._fleet.world
        self._disk = MemoryDisk()
        self._ids = Random(f'missions {seed}')
        self._site = JobSite()
        self._site.goals = goals_of(site.graph.vertices.values())
        self._judge = Judge({name: GoalPlace(vertex, site.graph.vertices[vertex].x,
                                         site.graph.vertices[vertex].y)
                             for name, vertex in self._named_goals().items()})
        self._jobs: Dict[str, WatchedJob] = {}
        self._refused: List[DayError] = []
        self._start_job_server()

    def _named_goals(self) -> Dict[str, int]:
        """Returns the goals by their names and by their ids; commands may contain either."""
        goals = dict(self._site.goals or {})
        return {**{str(vertex): vertex for vertex in goals.values()}, **goals}

    def _start_job_server(self) -> None:
        """Starts the job server with the jobs that are on the disk; the program logs in."""
        self._book = JobBook(
            self._disk.jobs.values(), self._disk.counters, self._disk,
            lambda: round(1000.0 * (self._world.wall + self._world.now)),
            lambda: self._ids.randint(1, 2 ** 31 - 1))
        self._server = JobServer(JobCommands(self._book, self._site), b'')
        self._program: ClientSession = self._server.connect(ClientPhase.OPEN)

    # -- the day -----------------------------------------------------------------------------------

    def play(self) -> PlayedDay:
        """Plays the day, and judges it."""
        world, waiting = self._world, list(reversed(self._lines))
        latest = self._lines[-1].at - self._begin + LONGEST_REST
        next_tick, trouble = 0.0, ''
        try:
            self._fleet.begin()
            while world.now < latest and (waiting or any(job.is_open for job in self._book.jobs)):
                while waiting and waiting[-1].at - self._begin <= world.now:
                    self._send(waiting.pop())
                world.step()
                if world.now >= next_tick or self._desk.news:
                    next_tick = world.now + TICK
                    self._work()
        except AssertionError as failure:
            trouble = f'The fleet broke its rules: {str(failure).splitlines()[0]}'
        self._work()
        self._judge_ends()
        world.end()
        wrong = ([trouble] if trouble else []) + self._judge.wrong
        hours = (world.now - (self._lines[0].at - self._begin)) / 3600.0
        return PlayedDay(self._begin, hours, len(world.agvs), self._judge.jobs, self._refused,
                         wrong)

    def _work(self) -> None:
        """Does the periodic work of the node, and lets the judge see the robots."""
        world = self._world
        for name, robot in world.agvs.items():
            self._judge.sees(name, *robot.position, world.now)
        while self._desk.news:
            news, self._desk.news = self._desk.news, []
            for mission, stamp, shown in news:
                self._server.announce(
                    self._book.hear_unknown(mission, stamp, world.now) if shown is None
                    else self._book.hear(mission, stamp, shown, world.now))
        self._server.announce(self._book.hear_drives(self._desk.drives()))
        for message in [*self._book.silent(world.now), *self._book.due(world.now)]:
            self._desk.handle(message)
        self._book.store_news()
        self._listen()

    def _send(self, line: DayLine) -> None:
        """Sends the command of a line, or does its restart."""
        if line.name == RESTART:
            self._restart(line.words[0])
            return
        command = line.command(lambda job, number: self._jobs[job.lower()].segments[number - 1].id
                               if job.lower() in self._jobs else f'{job}.{number}')
        self._listen()
        self._program.receive(command.encode() + b'\n')
        self._listen(line)

    def _restart(self, what: str) -> None:
        if what == 'fleet_manager':
            self._world.restart()
        else:
            self._listen()
            self._start_job_server()

    def _listen(self, line: Optional[DayLine] = None) -> None:
        """Lets the program read. `line`: the line whose command it has just sent, or None."""
        told = self._program.output.decode().split('\r\n')[:-1]
        self._program.output.clear()
        replies = [one for one in told if not one.startswith(_UPDATE)]
        if line is not None:
            known = len(self._judge.jobs)
            self._judge.hears_reply(line.number, replies, self._world.now)
            self._jobs.update((job.id.lower(), job) for job in self._judge.jobs[known:])
            refusals = [one for one in replies if one.startswith('CommandErrorDescription: ')]
            if refusals:
                self._refused.append(DayError(line, refusals[-1]))
            elif line.queues != (len(self._judge.jobs) > known):
                self._judge.wrong.append(f'Line {line.number} was answered with: '
                                         f'{" / ".join(replies) or "nothing"}')
        for one in told:
            if one.startswith(_UPDATE):
                self._judge.hears(one, self._world.now)

    def _judge_ends(self) -> None:
        for job in self._judge.jobs:
            mission = self._disk.missions.get(job.segments[0].id, 0)
            last = self._desk.last.get(mission)
            if last is None:
                self._judge.lost(job)
            else:
                self._judge.ends(job, last, self._desk.serials[mission])
