"""A page with a small site, robots and missions, without ROS and without a fleet manager."""
from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import threading
import time
from pathlib import Path
from typing import Any, List, Optional, Tuple

from browser_guard.certificates import certificates_of
from fleet_core.supervision.history import HistoryLine
from fleet_page.core.acts import Act, ActKind, ActOutcome
from fleet_page.core.fleet import MissionRequest, MissionStatus, ShownPlan, ShownPose, ShownRobot
from fleet_page.core.page import Missions, Page
from fleet_page.core.records import Records
from fleet_page.core.replay import ReplayRing
from fleet_page.core.roles import Person, TokenFile, Tokens, UserRole, load_tokens
from fleet_page.door.door import Access, Door
from fleet_page.door.files import CHART, PageFiles
from fleet_page.door.security import Addresses
from fleet_page.door.worker import Worker
from fleet_page.web.server import WebServer, serve
from trajectory_graph import CurveType, Edge, Graph, Vertex

PAGE_FOLDER = Path(__file__).parents[1] / 'page'
TOKENS = {'see': 'a-token-that-only-sees', 'operate': 'a-token-that-operates',
          'admin': 'a-token-that-administers'}


def graph(columns: int = 4, rows: int = 3) -> Graph:
    """A grid of vertices 3 m apart, joined by lines along rows and columns."""
    vertices = [Vertex(1 + x + y * columns, 3.0 * x, 3.0 * y, 0.0, dock=not x + y,
                       label='dock' if not x + y else '')
                for y in range(rows) for x in range(columns)]
    ends = [(v.id, v.id + 1) for v in vertices if v.id % columns] + [
        (v.id, v.id + columns) for v in vertices if v.id + columns <= columns * rows]
    return Graph(vertices, [Edge(k, a, b, CurveType.LINE, 0.0, 0.0, 1.0, 1.0)
                            for k, (a, b) in enumerate(ends, 1)])


def robot(name: str = 'a', **values: Any) -> ShownRobot:
    """Returns a robot that drives along edge 1 to vertex 2 and waits for nothing."""
    known = {'type': 'agv', 'state': 'BUSY', 'outage': 'NONE', 'edge': 1, 'fraction': 0.5,
             'seen': 100.0, 'battery': 0.75, 'mission': 7, 'destination': 2, 'waits_for': ''}
    return ShownRobot(name, **{**known, **values})


def status(id: int = 7, state: str = 'ACTIVE', **values: Any) -> MissionStatus:
    """The published state of a mission."""
    known = {'stamp': id * 10 ** 9, 'robot': 'a', 'reached': 0, 'reason': '',
             'told': time.time()}
    return MissionStatus(id, state=state, **{**known, **values})


def request(id: int = 7, *destinations: int) -> MissionRequest:
    """The request of a mission."""
    return MissionRequest(id, id * 10 ** 9, destinations or (2, 3), '', '', 1, 'anna')


def no_missions(since: float) -> List[HistoryLine]:
    """A journal without missions."""
    return []


def page(folder: str, journal: Missions = no_missions, **values: Any) -> Page:
    """A page without content."""
    return Page(Records(os.path.join(folder, 'page.sqlite')),
                ReplayRing(os.path.join(folder, 'replay')), journal, **values)


def show_fleet(shown: Page, now: Optional[float] = None) -> None:
    """Shows a site, two robots, a plan and three missions."""
    now = time.time() if now is None else now
    model = shown.model
    model.graph = graph()
    shown.site.radii = {'agv': 0.4}
    model.site_changed()
    model.update_robots([robot(to_end=90.0), robot(
        'b', state='FAILED', outage='FAILED', mission=None, edge=2, waits_for='wheel blocked',
        destination=0, battery=None)], now)
    model.update_places({'a': ShownPose(1.5, 0.0, 0.0), 'b': ShownPose(4.5, 0.0, None)})
    for id, state in ((7, 'ACTIVE'), (8, 'PENDING'), (9, 'SUCCEEDED')):
        model.note_request(request(id))
        shown.update_status(status(id, state, robot='' if state == 'PENDING' else 'a'))
    shown.update_plans({'a': ShownPlan((1, 2), 1)}, now)


class FakeFleet:
    """Stands in for the fleet manager: accepts acts, and records them with the persons' names."""

    def __init__(self) -> None:
        self.acts: List[Tuple[Act, Person]] = []
        self.slow: Optional[threading.Event] = None
        """If this is not None, all acts except stops wait for the event."""

    def do(self, act: Act, person: Person) -> ActOutcome:
        """Carries out an act for `WebServer`."""
        if self.slow is not None and act.kind is not ActKind.STOP:
            self.slow.wait(10.0)
        self.acts.append((act, person))
        return ActOutcome(True, f'{act.kind.value} was asked',
                          77 if act.kind is ActKind.SEND else 0)

    def stop(self, person: str) -> ActOutcome:
        """Carries out a stop for `Door`."""
        return self.do(Act(ActKind.STOP), Person(person, UserRole.OPERATE))

    @property
    def kinds(self) -> List[ActKind]:
        """The kinds of the acts, in order."""
        return [act.kind for act, _ in self.acts]


def token_file(folder: Path, mode: int = 0o600) -> str:
    """Writes a token file with three persons, one for each role. Returns its path."""
    path = folder / 'tokens'
    path.write_text('# role name token\n' + ''.join(
        f'{role} {role}r {token}\n' for role, token in TOKENS.items()))
    path.chmod(mode)
    return str(path)


def tokens(folder: Path) -> Tokens:
    """Returns the tokens of `token_file`, loaded."""
    return load_tokens(token_file(folder))


class ServedSite:
    """A page and its door in one event loop, with a fleet that accepts all acts."""

    def __init__(self, folder: Path, secured: bool = False, journal: Missions = no_missions,
                 chart: str = CHART, pair: Optional[Tuple[str, str]] = None) -> None:
        self.page, self.fleet = page(str(folder), journal), FakeFleet()
        self.web = WebServer(self.page, self.fleet.do)
        self._socket = str(folder / 'socket')
        self._access = Access(Addresses.of('127.0.0.1', (), pair is not None),
                              TokenFile(token_file(folder)) if secured else None, pair is not None)
        self._chart, self._pair = chart, pair
        self.port = 0

    async def open(self) -> None:
        """Begins to serve at a free port of loopback."""
        self._runner = await serve(self.web, self._socket)
        self.door = Door(self._access, PageFiles(str(PAGE_FOLDER), self._chart), self.fleet.stop,
                         Worker(self._socket))
        self.port = await self.door.listen(
            '127.0.0.1', 0, certificates_of(*self._pair) if self._pair else None)

    async def hang(self) -> None:
        """Makes the page's process accept no connections any more, like a process that is stopped.
        """
        await self._runner.cleanup()
        with contextlib.suppress(FileNotFoundError):  # some versions of Python remove it
            os.unlink(self._socket)
        self._hanging = socket.socket(socket.AF_UNIX)
        self._hanging.bind(self._socket)
        self._hanging.listen(200)

    async def go_on(self) -> None:
        """Makes the page's process work again."""
        self._hanging.close()
        os.unlink(self._socket)
        self.web = WebServer(self.page, self.fleet.do)
        self._runner = await serve(self.web, self._socket)

    async def close(self) -> None:
        """Ends all connections."""
        await self.door.close()
        await self._runner.cleanup()


async def until(condition: Any, seconds: float = 5.0) -> None:
    """Waits in an event loop until the condition is true."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, 'the condition did not become true'
        await asyncio.sleep(0.01)
