"""The driving of one route: where to send the robot next, and what ends the route."""
from __future__ import annotations

import math
from enum import Enum
from typing import List, Optional, Tuple

from omron_ld90.bridge.robot_errand import DOCK, RobotErrand
from omron_ld90.bridge.robot_place import RobotPlace
from omron_ld90.bridge.route_place import PlaceOnGraph
from omron_ld90.bridge.route_progress import RouteProgress
from omron_ld90.bridge.route_protocol import EdgeState, RouteOrder, RouteRecord
from omron_ld90.bridge.route_settings import Settings
from omron_ld90.bridge.route_strategies import Outlook
from omron_ld90.converter.goals import goal_name

PROGRESS = 0.05         # m along the route that count as progress
ARRIVAL_PATIENCE = 2.0  # s for a location to show what the robot said
LEAD = 2.0              # s from our command to the robot's driving on a new way, and some to spare


class Phase(Enum):
    """What became of a route."""

    RUNNING = 'running'
    COMPLETE = 'complete'
    FAILED = 'failed'
    STOPPED = 'stopped'


class RouteFailed(Exception):
    """The route cannot go on; `reason` is for the fleet manager, the text for people."""

    def __init__(self, reason: str, detail: str = '') -> None:
        super().__init__(reason, detail)
        self.reason = reason
        self.detail = detail

    def __str__(self) -> str:
        return f'{self.reason.rstrip(".")}. {self.detail}'.rstrip()


class TakenOver(RouteFailed):
    """The robot obeys somebody else already, so that it is not ours to stop."""

    def __init__(self, how: str) -> None:
        super().__init__('taken over', how)


class RouteRun:
    """A route, how far it is driven, and where the robot was sent for it.

    Methods that take an event raise RouteFailed where it ends the route.
    """

    def __init__(self, order: RouteOrder, settings: Settings, errand: RobotErrand,
                 seen: RobotPlace, progress: Optional[RouteProgress], now: float) -> None:
        """`progress` is None for an empty route."""
        self.order = order
        self.progress = progress
        self.phase = Phase.STOPPED if progress is None else Phase.RUNNING
        self.reason = ''
        self._settings = settings
        self._errand = errand
        self._seen = seen
        self._target: Optional[int] = None  # index of the edge to whose end the robot was sent
        self._arrived_at = -math.inf        # when the robot said that it had reached that
        self._sent_back: List[int] = []     # indices of vertices that it missed
        self._strayed = False               # the last location was off the corridor
        self._allowed: Tuple[int, Tuple[int, ...]] = (-1, ())
        self._best = -math.inf
        self._best_at = now

    # --- how far it is ---------------------------------------------------------------------------

    @property
    def running(self) -> bool:
        """Whether the route is being driven."""
        return self.phase is Phase.RUNNING

    @property
    def edges(self) -> Tuple[int, ...]:
        """Signed ids, as ordered."""
        return self.order.edges

    @property
    def states(self) -> Tuple[EdgeState, ...]:
        """One state per edge."""
        if self.progress is None:
            return ()
        done = self.progress.current
        rest = EdgeState.FAILED if self.phase is Phase.FAILED else EdgeState.PROCESSING
        return (EdgeState.COMPLETE,) * done + (rest,) * (len(self.edges) - done)

    @property
    def record(self) -> Optional[RouteRecord]:
        """What a restarted bridge needs to go on; None where there is nothing to go on with."""
        if self.progress is None or self.phase is Phase.FAILED:
            return None
        current = self.progress.current
        return RouteRecord(self.order.route_id, self.edges, current,
                           current if self._target is None else max(current, self._target))

    @property
    def edges_under_way(self) -> Tuple[int, ...]:
        """From the edge just driven to the one behind the target: where the robot may brake."""
        current = self.progress.current
        return self.edges[max(current - 1, 0):max(current, self._target or 0) + 2]

    def is_on(self, edge: int) -> bool:
        """Is the robot on this edge, or just past it, or did it fail on it?"""
        if self.phase not in (Phase.RUNNING, Phase.FAILED):
            return False
        current = self.progress.current
        return edge in self.edges[max(current - 1, 0) if self.running else current:current + 1]

    def decides_pose(self, here: PlaceOnGraph) -> bool:
        """Is the robot driving the route, or has it stayed where the route ended?"""
        if self.phase is not Phase.COMPLETE:
            return self.running
        end = self.progress.end(-1)
        if here.is_docked:
            return end.id == self._settings.dock_vertex
        return math.dist(here.position, end.position) <= self._settings.vertex_tolerance

    # --- driving ---------------------------------------------------------------------------------

    def allow(self, edges: Tuple[int, ...]) -> None:
        """Lets the robot brake on `edges`, which it is on its way along, while on this edge."""
        self._allowed = (self.progress.current, edges)

    def replace(self, order: RouteOrder, now: float) -> None:
        """Goes on with more or fewer edges."""
        self.allow(self.edges_under_way)
        self.order = order
        self.progress.replace_edges(order.edges)
        if not self.progress.done:
            self.phase = Phase.RUNNING
            self._target = None
            self._best_at = now
            self.drive()

    def drive(self) -> None:
        """Sends the robot where the strategy wants it, unless it is on its way there.

        To a vertex that it missed it goes first, whatever the strategy.
        """
        if self.progress.done:
            return
        target = self.progress.current
        if target not in self._sent_back:
            target = self._settings.strategy(Outlook(
                self.progress, self._target, self._errand.reached, self._horizon(),
                self._settings.corridor_width))
        if target != self._target:
            self._send_to(target)

    def locate(self, here: PlaceOnGraph, now: float) -> str:
        """The robot was seen; what people should know of that, or nothing."""
        self.progress.move_to(*here.position)
        self._check_corridor(here)
        if (self.progress.current < self._target and self.progress.has_overshot()
                and not here.is_docked):
            return self._send_back(now)
        self._settle()
        return ''

    def arrive(self, now: float) -> None:
        """The robot says that it has reached the goal last sent."""
        self._arrived_at = now
        self._settle()

    def count_as_progress(self, now: float) -> None:
        """Something moved on that is no way along the route, such as docking."""
        self._best_at = now

    def check_clock(self, now: float) -> str:
        """Looks at what takes too long; what people should know, or nothing."""
        if self.progress.travelled > self._best + PROGRESS:
            self._best = self.progress.travelled
            self._best_at = now
        if now - self._best_at > self._settings.stall_timeout:
            raise RouteFailed(f'no progress for {self._settings.stall_timeout:.0f} s')
        if not self._errand.reached or now - self._arrived_at < ARRIVAL_PATIENCE:
            return ''
        if self.progress.current < self._target:
            return self._send_back(now)
        raise RouteFailed(f'the robot says that it is at {self._errand.goal}, but is '
                          f'{self._distance_to_target():.1f} m away from it')

    def _settle(self) -> None:
        """Takes the robot's word that it has arrived, once it is seen there, and goes on."""
        if (self._errand.reached and self.progress.current == self._target
                and (self._errand.goal == DOCK
                     or self._distance_to_target() <= self._settings.vertex_tolerance)):
            self.progress.complete_current()
        if self.progress.done:
            self.phase = Phase.COMPLETE
            self._errand.end()
        else:
            self.drive()

    def _send_to(self, index: int) -> None:
        self._target = index
        vertex = self.progress.end(index)
        goal = DOCK if vertex.id == self._settings.dock_vertex else goal_name(vertex)
        if goal == self._errand.goal and not self._errand.reached:
            return  # it is on its way there: no motion command is repeated
        via: List[str] = []
        if goal == DOCK:
            command = DOCK
        elif self._settings.native_command:
            via = [goal_name(self.progress.end(i)) for i in range(self.progress.current, index)]
            command = self._settings.native_command.format(
                goals=' '.join([*via, goal]), last=goal)
        else:
            command = f'goto {goal}'
        self._errand.send(command, goal, via)

    def _send_back(self, now: float) -> str:
        """The robot cut a corner so far that it missed a vertex: back to that, once."""
        current = self.progress.current
        vertex = self.progress.end(current).id
        if current in self._sent_back:
            raise RouteFailed(f'the robot went by vertex {vertex} without coming near it')
        self._sent_back.append(current)
        self.allow(self.edges_under_way)
        self.count_as_progress(now)
        self._send_to(current)
        return f'The robot missed vertex {vertex} and is sent back to it.'

    def _check_corridor(self, here: PlaceOnGraph) -> None:
        """Fails the route when the robot is outside the corridors twice in a row."""
        edges = self.edges[max(self.progress.current - 1, 0):
                           max(self.progress.current, self._target) + 1]
        until, allowed = self._allowed
        if self.progress.current <= until:
            edges += allowed
        strays = not here.is_about_the_dock and here.nearest_of(edges) is None
        if strays and self._strayed:
            raise RouteFailed('off the corridor')
        self._strayed = strays

    def _horizon(self) -> float:
        """Distance in m at which the robot may begin to brake before it is looked at again."""
        settings, seconds = self._settings, self._seen.period + LEAD
        speed = min(settings.top_speed, self._seen.speed + settings.acceleration * seconds)
        return speed * speed / (2.0 * settings.braking) + speed * seconds

    def _distance_to_target(self) -> float:
        return math.dist((self._seen.last.x, self._seen.last.y),
                         self.progress.end(self._target).position)
