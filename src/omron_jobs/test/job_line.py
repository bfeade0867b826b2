"""A job server for tests, with two ARCL clients, a disk and a fleet manager; without I/O."""
from __future__ import annotations

import calendar
import time
from typing import List, Optional

from job_fleet import Disk, FakeFleet, Key, tell

from omron_jobs.core.client_session import ClientSession, JobServer
from omron_jobs.core.job_book import JobBook
from omron_jobs.core.job_commands import JobCommands, JobSite
from omron_jobs.core.jobs import DriveAct, JobMissionState

BEGIN = calendar.timegm((2011, 12, 19, 6, 54, 18)) * 1000
AT, LATER = '12/19/2011 06:54:18', '12/19/2011 06:54:34'
LOGIN = b'secret\n'
ACTIVE = JobMissionState.ACTIVE


class Line:
    """A job server with two clients, its disk and its fleet manager."""

    def __init__(self, disk: Optional[Disk] = None, fleet: Optional[FakeFleet] = None) -> None:
        self.disk, self.fleet = disk or Disk(), fleet or FakeFleet()
        self.now_ms, self.now = BEGIN, 0.0
        ids = iter(range(1000 + self.disk.counters.number, 10 ** 6))
        self.book = JobBook(self.disk.jobs.values(), self.disk.counters, self.disk,
                            lambda: self.now_ms, lambda: next(ids))
        self.site = JobSite()
        self.site.goals = {'x': 1, 'y': 2, 'z': 3, 'goal 4': 4}
        self.server = JobServer(JobCommands(self.book, self.site, lambda: time.gmtime(
            self.now_ms / 1000)), b'secret')
        self.client, self.other = self.log_in(), self.log_in()

    def log_in(self) -> ClientSession:
        client = self.server.connect()
        client.receive(LOGIN)
        self.heard(client)
        return client

    def heard(self, client: Optional[ClientSession] = None) -> List[str]:
        """Returns the lines that a client (default: the first one) got since the last call."""
        client = client or self.client
        lines = client.output.decode().split('\r\n')
        client.output.clear()
        assert lines.pop() == ''
        return lines

    def say(self, line: str) -> List[str]:
        """Sends a line of the first client. Returns the answer."""
        self.client.receive(line.encode() + b'\r\n')
        return self.heard()

    def exchange(self) -> List[str]:
        """Lets the fleet manager handle messages due. Returns the lines for the first client."""
        for message in self.book.due(self.now):
            for key, shown in self.fleet.handle(message):
                self.server.announce(tell(self.book, key, shown, self.now))
        return self.heard()

    def key(self, number: int = -1) -> Key:
        job = self.book.jobs[number]
        return job.mission, job.queued

    def show(self, key: Key) -> List[str]:
        """Lets the fleet manager report a mission. Returns the lines for the first client."""
        self.server.announce(tell(self.book, key, self.fleet.missions[key].shown, self.now))
        return self.heard()

    def set(self, state: JobMissionState, robot: Optional[str] = None, number: int = -1,
            ) -> List[str]:
        """Gives a mission a state; its robot, if it has one, drives.

        Returns the lines for the first client.
        """
        self.fleet.set(self.key(number), state, robot)
        return [*self.show(self.key(number)), *self.drive()]

    def drive(self, act: DriveAct = DriveAct.DRIVES) -> List[str]:
        """Lets the fleet manager report what robots do. Returns the lines for the first client."""
        drives = {key: drive._replace(act=act) for key, drive in self.fleet.drives().items()}
        self.server.announce(self.book.hear_drives(drives))
        return self.heard()

    def reach(self, number: int = -1) -> List[str]:
        self.fleet.reach(self.key(number))
        return [*self.show(self.key(number)), *self.drive()]

    def wait(self, seconds: float) -> None:
        self.now_ms += int(1000 * seconds)
        self.now += seconds
