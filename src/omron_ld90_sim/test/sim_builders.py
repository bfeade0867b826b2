"""Common parts of the simulator's tests: rooms, robots without sockets, true obstacles."""
from __future__ import annotations

import math
import os
from functools import lru_cache
from pathlib import Path
from typing import List, Optional, Tuple

import numpy as np
from scipy.spatial import cKDTree

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.clock import SimClock
from omron_ld90_sim.interface.commands import execute
from omron_ld90_sim.interface.server import ArclServer
from omron_ld90_sim.interface.session import SimSession
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import LD90_BODY, SimPose
from omron_map import MapDocument, MapObject, RotatedRectangle

ROOT = Path(__file__).resolve().parents[3]
LAB = ROOT / 'maps' / 'lab.map'
# /nowhere: LD90_REAL_MAPS names no folder
REAL_MAPS = Path(os.environ.get('LD90_REAL_MAPS') or '/nowhere')
MAPS = [LAB, REAL_MAPS / 'omron-ld-site-a.map', REAL_MAPS / 'omron-ld-site-b.map']

ROOM = """2D-Map
LineMinPos: -4000 -3000
LineMaxPos: 6000 3000
NumLines: 5
LinesAreSorted: false
MapInfo: DockType Name=DockLynx
MapInfo: GoalType Name=Goal
MapInfo: GoalType Name=GoalWithHeading
RouteInfo: Route "Round"
RouteInfo: Goal "West"
RouteInfo: Goal "East side"
MacroInfo: Macro "Greeting"
MacroInfo: Task "say" "hello"
MacroInfo: Task "wait" 2
Cairn: Goal -3000 1500 0.000000 "" ICON "West"
Cairn: DockLynx -2500 -2000 180.000000 "" ICON "Dock 1"
Cairn: GoalWithHeading 4500 1500 90.000000 "the far end" ICON "East side"
Cairn: Goal 4500 -2000 0.000000 "" ICON "12"
LINES
-4000 -3000 6000 -3000
-4000 3000 6000 3000
-4000 -3000 -4000 3000
6000 -3000 6000 3000
1000 -3000 1000 1000
"""


@lru_cache(maxsize=None)
def room() -> MapDocument:
    """Returns a room of 10 x 6 m with a wall in it, a dock, three goals, a route and a macro."""
    return MapDocument.from_bytes(ROOM.encode(), name='room.map')


def corridor(width: float) -> MapDocument:
    """Returns a corridor along x, 24 m long and `width` mm wide, with 4 x 6 m rooms at its ends."""
    side = width / 2
    walls = [(-12000, y, 12000, y) for y in (-side, side)]
    for x, end in ((-12000, -16000), (12000, 16000)):
        walls += [(x, side, x, 3000), (x, -side, x, -3000), (x, 3000, end, 3000),
                  (x, -3000, end, -3000), (end, -3000, end, 3000)]
    lines = '\n'.join(' '.join(f'{value:.0f}' for value in wall) for wall in walls)
    return MapDocument.from_bytes(
        f'2D-Map\nLineMinPos: -16000 -3000\nLineMaxPos: 16000 3000\nNumLines: {len(walls)}\n'
        f'LINES\n{lines}\n'.encode(), name='corridor.map')


def lonely_floor(*walls: Tuple[float, float, float, float]) -> SimFloor:
    """Returns a floor of 10 x 8 m with walls around it, and with further `walls`."""
    everything = np.array([[-5000, -4000, 5000, -4000], [-5000, 4000, 5000, 4000],
                           [-5000, -4000, -5000, 4000], [5000, -4000, 5000, 4000], *walls], float)
    return SimFloor(np.empty((0, 2)), everything, np.empty((0, 4)), [], 20, np.empty((0, 2)))


@lru_cache(maxsize=4)
def floor_of(document: MapDocument) -> SimFloor:
    """Returns the floor of a map; no test changes it."""
    return SimFloor.from_map(document)


class Rig:
    """A robot and its ARCL server without sockets, on a new clock or on a given clock."""

    def __init__(self, document: Optional[MapDocument] = None,
                 start: Optional[Tuple[float, float, float]] = (-3000.0, 0.0, 0.0),
                 seed: int = 0, battery: float = 100.0,
                 arrival_error: Tuple[float, float] = (0.0, 0.0),
                 clock: Optional[SimClock] = None) -> None:
        self.clock = clock or SimClock()
        document = document or room()
        self.robot = SimRobot(self.clock, document, floor_of(document),
                              SimPose(*start) if start else None, seed, battery,
                              arrival_error=arrival_error)
        self.server = ArclServer(self.clock, self.robot, 'adept', execute)

    def client(self) -> Client:
        """Returns a client that has logged in."""
        client = Client(self, self.server.connect())
        client.send('adept')
        client.lines()
        return client


def fleet(document: MapDocument, *starts: Tuple[float, float, float], seed: int = 0) -> List[Rig]:
    """Returns robots that see each other and have the same clock."""
    clock = SimClock()
    rigs = [Rig(document, start, seed + number, clock=clock)
            for number, start in enumerate(starts)]
    for rig in rigs:
        rig.robot.navigation.neighbours = [other.robot.navigation for other in rigs
                                           if other is not rig]
    return rigs


def _outline() -> np.ndarray:
    corners = LD90_BODY.corners(SimPose(0.0, 0.0, 0.0))
    return np.concatenate([np.linspace(start, end, 40) for start, end in
                           zip(corners, np.roll(corners, -1, axis=0))])


OUTLINE = _outline()        # points all around the body at the origin
FAR = 300.0  # mm between two bodies, beyond which an approximate value is enough


def gap(a: SimPose, b: SimPose) -> float:
    """Returns the gap between two robots' bodies (mm): 0 if they touch. If the gap is large, it is
    a lower bound.
    """
    apart = a.distance_to(b.x, b.y) - 2.0 * LD90_BODY.half_diagonal
    if apart > FAR:
        return apart

    def one_way(a: SimPose, b: SimPose) -> float:
        angle = math.radians(b.theta)
        turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
        return float(outside(a, OUTLINE @ turn + [b.x, b.y]).min())

    return min(one_way(a, b), one_way(b, a))


def outside(pose: SimPose, points: np.ndarray) -> np.ndarray:
    """Returns the distance (mm) from the body at `pose` to each point (N, 2); 0 inside the body."""
    angle = math.radians(pose.theta)
    delta = points - [pose.x, pose.y]
    ahead = np.abs(delta[:, 0] * math.cos(angle) + delta[:, 1] * math.sin(angle))
    aside = np.abs(-delta[:, 0] * math.sin(angle) + delta[:, 1] * math.cos(angle))
    return np.hypot(np.maximum(ahead - LD90_BODY.half_length, 0.0),
                    np.maximum(aside - LD90_BODY.half_width, 0.0))


class Client:
    """One session, controlled by the test."""

    def __init__(self, rig: Rig, session: SimSession) -> None:
        self._rig, self.session = rig, session

    def send(self, *commands: str) -> None:
        """Sends commands, each with a line end."""
        for command in commands:
            self.session.receive(command.encode() + b'\n')

    def lines(self) -> List[str]:
        """Returns the lines that have arrived since the last call."""
        text = self.session.output.decode()
        self.session.output.clear()
        assert not text or text.endswith('\r\n'), f'an incomplete line: {text!r}'
        return text.split('\r\n')[:-1]

    def ask(self, *commands: str) -> List[str]:
        """Sends commands; returns the lines that come without further simulated time."""
        self.lines()
        self.send(*commands)
        return self.lines()

    def until(self, beginning: str, times: int = 1, seconds: float = 200.0) -> List[str]:
        """Runs the simulation until `times` lines begin with `beginning`; returns all new lines.

        Fails if they do not come within `seconds` of simulated time.
        """
        seen = self.lines()
        end = self._rig.clock.now + seconds
        while sum(line.startswith(beginning) for line in seen) < times:
            due = self._rig.clock.next_time
            assert due is not None and due <= end, f'no {beginning!r} came, only {seen}'
            self._rig.clock.advance(due)
            seen += self.lines()
        return seen


class Obstacles:
    """The true obstacles of a map, without a grid, for checks of a driven path."""

    def __init__(self, document: MapDocument) -> None:
        pieces = [np.asarray(document.points, float).reshape(-1, 2)]
        lines = [list(line) for line in np.asarray(document.lines).reshape(-1, 4)]
        lines += [[o.extent.from_x, o.extent.from_y, o.extent.to_x, o.extent.to_y]
                  for o in document.forbidden_lines]
        for area in document.forbidden_areas:
            corners = area.rectangle.corners
            lines += [[*a, *b] for a, b in zip(corners, np.roll(corners, -1, axis=0))]
        for x1, y1, x2, y2 in lines:
            count = int(math.hypot(x2 - x1, y2 - y1) / 10.0) + 2
            pieces.append(np.column_stack([np.linspace(x1, x2, count),
                                           np.linspace(y1, y2, count)]))
        self._tree = cKDTree(np.concatenate(pieces))
        self._points = np.concatenate(pieces)
        self.areas: List[RotatedRectangle] = [o.rectangle for o in document.forbidden_areas]

    def forbidden(self, pose: SimPose) -> bool:
        """Returns whether the turning centre is inside a forbidden area."""
        centre = np.array([[pose.x, pose.y]])
        return any(area.contains(centre)[0] for area in self.areas)

    def distance(self, pose: SimPose) -> float:
        """Returns the distance (mm) from the body's outline to the nearest wall, point or border
        of an area.
        """
        near = self._tree.query_ball_point((pose.x, pose.y), 700.0)
        return float(outside(pose, self._points[near]).min()) if near else 270.0

    def clearances(self, places: np.ndarray) -> np.ndarray:
        """Returns the distance (mm) to the nearest obstacle from places (N, 2) of the turning
        centre.
        """
        return self._tree.query(places)[0]


def goal(document: MapDocument, name: str) -> MapObject:
    """Returns the goal called `name`."""
    found = document.find(name)
    assert found is not None, name
    return found
