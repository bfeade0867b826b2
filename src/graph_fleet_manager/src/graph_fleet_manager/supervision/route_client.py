"""The fleet manager's side of the route protocol, for one robot.

All edges that a robot was ever given are counted through, whatever the ids of its routes: the
*track*. What is on it and not yet left is the robot's alone; a track only gets shorter when a
report says so.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Set, Tuple

from graph_fleet_manager.supervision.reports import Place, Pose, Report, place_of
from trajectory_graph import Graph
from trajectory_graph.route_protocol import RouteRefusal

REPEAT = 1.0      # s after which an order that was not acknowledged is repeated
NEW_ID_AFTER = 50  # edges
_NOT_OVER = 1.0 - 1e-9  # the fraction of an edge that is nearly driven
_OVERTAKEN = 10.0  # s: a report that is older than the last by more tells of a clock set back

NewId = Callable[[], int]
"""Gives a route id that was never used."""


class Order(NamedTuple):
    """A route as sent to the robot: the edges of the track from `base` on."""

    route_id: int
    base: int
    edges: Tuple[int, ...]


class Sending(NamedTuple):
    """An order to be sent now; a repeated one goes out exactly as before."""

    route_id: int
    edges: Tuple[int, ...]
    repeated: bool = False


class Memory(NamedTuple):
    """What must outlive a restart; the edges of the track are counted from 0 here."""

    route_id: int
    track: Tuple[int, ...]
    done: int
    bases: Mapping[int, int]
    place: Optional[Place]
    over: bool
    ended: Tuple[int, ...] = ()


@dataclass
class Heard:
    """What a report told.

    passed  -- vertices passed since the last report, in order
    failed  -- why the route failed; empty: it did not
    refused -- why an order was not taken up; empty: it was
    foreign -- the robot drives a route that it was not given here
    left    -- nothing is to be driven, but the robot is not where its route ended
    """

    passed: List[int] = field(default_factory=list)
    failed: str = ''
    refused: str = ''
    foreign: bool = False
    left: bool = False


class RouteClient:
    """Orders routes, repeats what is not acknowledged, and follows the reports.

    speed -- m/s, the most that the robot may drive back in the time that a report is old
    slack -- m that it may be short of where it reports to be
    """

    def __init__(self, graph: Graph, speed: float, slack: float = 0.0) -> None:
        self.graph = graph
        self.place: Optional[Place] = None
        """Where the robot stands, or stood before its track; None: nobody knows."""
        self.track: List[int] = []
        self.first = 0
        """Number of the first edge that is still in `track`."""
        self.done = 0
        """Number of the edge that is being driven: so many are complete."""
        self.left: Tuple[int, float] = (0, 0.0)
        """Edge and fraction that certainly lie behind the robot."""
        self.route_id = 0
        self.order: Optional[Order] = None
        """What is not acknowledged yet."""
        self.over = True
        """The last route cannot be extended: another one needs another id."""
        self.pose = Pose()
        self._speed, self._slack = speed, slack
        self._bases: Dict[int, int] = {}
        self._acknowledged: Set[int] = set()
        self._ended: Set[int] = set()
        self._reported = 0
        self._sent_at: Optional[float] = None
        self._awaits_report = False
        self._stamp = 0.0

    # -- what is known ----------------------------------------------------------------------------

    @property
    def end(self) -> int:
        """Number behind the last edge of the track."""
        return self.first + len(self.track)

    @property
    def ahead(self) -> Tuple[int, ...]:
        """The edges not yet complete, the one being driven first."""
        return tuple(self.track[self.done - self.first:])

    @property
    def held(self) -> Tuple[int, ...]:
        """The edges that nobody else may be given."""
        return tuple(self.track[max(self.left[0] - self.first, 0):])

    @property
    def is_standing(self) -> bool:
        """Is everything driven that was ordered?"""
        return self.done == self.end

    @property
    def is_ready(self) -> bool:
        """May it be given more? Not while it is being shortened, or after a refusal."""
        return not self._awaits_report and (self.order is None or not self._is_shorter(self.order))

    @property
    def last_vertex(self) -> Optional[int]:
        """Where the track ends; None between vertices and nowhere."""
        if self.ahead:
            return self.graph.end_vertex(self.ahead[-1]).id
        return self.place.vertex if self.place else None

    def distance_ahead(self) -> float:
        """Length (m) of what is still to be driven."""
        edges = self.ahead
        if not edges:
            return 0.0
        whole = sum(self.graph.curve(edge).length for edge in edges)
        fraction = self.pose.fraction if self.pose.edge == edges[0] else 0.0
        return whole - fraction * self.graph.curve(edges[0]).length

    # -- orders -----------------------------------------------------------------------------------

    def extend(self, edges: Sequence[int], new_id: NewId, renew: bool = False) -> None:
        """Lets the robot drive more edges; `renew`: under a new id, as for another mission."""
        if self.is_standing and self.place is not None and self.place.vertex is None:
            fraction = self.place.fraction if edges[0] == self.place.edge else (
                1.0 - self.place.fraction)
            slack = self._slack / self.graph.curve(edges[0]).length
            self.left = (self.done, min(max(fraction - slack, 0.0), _NOT_OVER))
        if renew or self.over or self.end - self._bases[self.route_id] >= NEW_ID_AFTER:
            self._begin(new_id())
        self.track += edges
        self._order_all()

    def shorten(self, new_id: NewId) -> bool:
        """Asks the robot to stop at the end of its edge; tells whether it may drive farther."""
        if len(self.ahead) <= 1:
            return False
        if self._awaits_report or (self.order is not None and self._is_shorter(self.order)):
            return True
        if self.over:
            self._begin(new_id())
        base = self._bases[self.route_id]
        self._give(Order(self.route_id, base,
                         tuple(self.track[base - self.first:self.done + 1 - self.first])))
        return True

    def halt(self, new_id: NewId) -> None:
        """Stops the robot wherever it is; what it holds stays its own until `settle`."""
        self._begin(new_id())
        self.over = True
        self._awaits_report = False
        self._give(Order(self.route_id, self.done, ()))

    def try_again(self, new_id: NewId) -> None:
        """Orders once more, under a new id, what an emergency stop kept the robot from driving."""
        self._begin(new_id())
        self._give(Order(self.route_id, self.done, self.ahead))

    def settle(self, place: Optional[Place]) -> None:
        """The robot stands here, and holds nothing else any more."""
        self._ended = {*self._bases, self.route_id}
        self._bases = {}
        # One number is left out, so that no plan made before can fit what comes after.
        self.first = self.done = self.end + 1
        self.track = []
        self.left = (self.done, 0.0)
        self.place = place
        self.over = True
        self.order = None
        self._awaits_report = False

    def due(self, now: float) -> Optional[Sending]:
        """The order to send now, if there is one."""
        if self.order is None or self._awaits_report:
            return None
        repeated = self._sent_at is not None
        if self._sent_at is not None and now - self._sent_at < REPEAT:
            return None
        self._sent_at = now
        return Sending(self.order.route_id, self.order.edges, repeated)

    def _begin(self, route_id: int) -> None:
        kept = (self.route_id, self._reported)
        self._bases = {id: base for id, base in self._bases.items() if id in kept}
        self._bases[route_id] = self.done
        self.route_id = route_id
        self.over = False

    def _order_all(self) -> None:
        """Orders the whole track, from where the route begins."""
        base = self._bases[self.route_id]
        self._give(Order(self.route_id, base, tuple(self.track[base - self.first:])))

    def _give(self, order: Order) -> None:
        self.order = order
        self._sent_at = None

    def _is_shorter(self, order: Order) -> bool:
        return order.base + len(order.edges) < self.end

    # -- after a restart --------------------------------------------------------------------------

    @property
    def memory(self) -> Memory:
        """What `restore` needs after a restart; it is to be stored before an order is sent."""
        bases = {id: base - self.first for id, base in self._bases.items()}
        return Memory(self.route_id, tuple(self.track), self.done - self.first, bases, self.place,
                      self.over, tuple(sorted(self._ended)))

    def restore(self, memory: Memory) -> None:
        """What was known before: the robot may hold all of these edges."""
        self.route_id, self._bases = memory.route_id, dict(memory.bases)
        self.track, self.done = list(memory.track), memory.done
        self.left = (self.done, 0.0)
        self.place, self.over = memory.place, memory.over
        self._ended = set(memory.ended)

    def adopt(self, report: Report) -> None:
        """The first report after a restart, to be taken next: what it has not driven is fixed.

        An order that may still be under way to the robot is repeated until it is acknowledged.
        """
        base = self._bases.get(report.route_id)
        if base is None:
            if report.route_id in self._ended:
                if self.ahead and self.route_id in self._bases:
                    self._order_all()  # it did not reach the robot
            elif not self.ahead:
                self._adopt_other(report)
            # In any other case `take` finds that the robot was taken over, or lost its route.
        else:
            self._acknowledged.add(report.route_id)
            if report.is_failed:
                return
            end = base + len(report.edges)
            if self.end > end or report.route_id != self.route_id:
                self._order_all()

    def _adopt_other(self, report: Report) -> None:
        """A route of which nothing is known here; a stop that is under way stays so."""
        self.first = self.end
        self.track, self.done = list(report.edges), self.first
        self.left = (self.done, 0.0)
        self._bases = {self.route_id: self.done} if self.order is not None else {}
        self._bases[report.route_id] = self.first
        self._acknowledged.add(report.route_id)
        if self.order is None:
            self.route_id = report.route_id
            self.over = not report.edges or report.is_failed
        if not report.is_running:
            self.place = place_of(report.pose, self.graph)

    # -- what the robot says ----------------------------------------------------------------------

    def take(self, report: Report) -> Heard:
        """Follows a report."""
        heard = Heard()
        if 0.0 < self._stamp - report.stamp < _OVERTAKEN:
            return heard
        self._stamp = report.stamp
        self._reported = report.route_id
        if self._awaits_report and report.route_id != self.route_id:
            self._take_truth(report)
        if report.route_id not in self._bases:
            self.pose = report.pose
            if report.is_running:
                heard.foreign = report.route_id not in self._ended
            elif self.order is None:
                heard.left = self.is_standing and self._has_left()
                if self.ahead and report.route_id not in self._ended:
                    heard.failed = 'it has forgotten its route'
            return heard
        base = self._bases[report.route_id]
        skipped = max(self.first - base, 0)
        mine = tuple(self.track[base + skipped - self.first:][:len(report.edges) - skipped])
        if mine != report.edges[skipped:]:
            heard.foreign = report.is_running
            return heard
        if report.is_failed and report.route_id not in self._acknowledged and report.completed == 0:
            return self.refuse(RouteRefusal(report.route_id, report.edges, report.reason))
        self._acknowledged = {id for id in self._acknowledged if id in self._bases}
        self._acknowledged.add(report.route_id)
        if self._awaits_report:
            self._take_truth(report)
        self.pose = report.pose
        self._acknowledge(report)
        heard.passed = self._complete(base + report.completed)
        self._leave(report.age)
        self._forget()
        if report.is_failed:
            self.order, self.over = None, True
            heard.failed = report.reason or 'it gave no reason'
        elif self.is_standing and self.order is None and report.edges:
            heard.left = self._has_left()
        return heard

    def refuse(self, refusal: RouteRefusal) -> Heard:
        """The robot did not take up an order: the next report tells what it really drives."""
        heard = Heard()
        if self.order is not None and (refusal.route_id, refusal.edges) == (
                self.order.route_id, self.order.edges):
            self.order = None
            self._awaits_report = True
            heard.refused = refusal.reason or 'it gave no reason'
        return heard

    def keep_after_refusal(self) -> None:
        """What was refused stays the robot's: it is to be ordered again."""
        self._awaits_report = False
        self.over = True

    def _take_truth(self, report: Report) -> None:
        """After a refusal: the robot holds what it reports, and nothing else of what was ordered.

        Another order needs another id.
        """
        self._awaits_report = False
        self.over = True
        base = self._bases.get(report.route_id)
        if base is None:
            end = self.done
        else:
            end = base + len(report.edges) if report.is_running else base + report.completed
        end = min(max(end, self.done), self.end)
        del self.track[end - self.first:]
        if base is not None:
            self._bases = {report.route_id: base}

    def _acknowledge(self, report: Report) -> None:
        order = self.order
        if order and report.route_id == order.route_id and len(report.edges) == len(order.edges):
            self.order = None
            if order.edges and self._is_shorter(order):
                del self.track[order.base + len(order.edges) - self.first:]

    def _complete(self, done: int) -> List[int]:
        passed = []
        while self.done < min(done, self.end):
            vertex = self.graph.end_vertex(self.track[self.done - self.first]).id
            self.done += 1
            self.place = Place(vertex=vertex)
            passed.append(vertex)
        return passed

    def _leave(self, age: float) -> None:
        """What certainly lies behind the robot, however old its report."""
        if self.is_standing:
            self.left = (self.done, 0.0)
            return
        edge = self.track[self.done - self.first]
        if self.pose.edge != edge:
            return
        number, arc = self.done, self.pose.fraction * self.graph.curve(edge).length
        arc -= self._slack + max(age, 0.0) * self._speed
        while arc < 0.0 and number > max(self.left[0], self.first):
            number -= 1
            arc += self.graph.curve(self.track[number - self.first]).length
        length = self.graph.curve(self.track[number - self.first]).length
        self.left = max(self.left, (number, min(max(arc / length, 0.0), _NOT_OVER)))

    def _forget(self) -> None:
        """Drops edges that are left and belong to no route that may still be reported."""
        keep = min([self.left[0], self.done, *self._bases.values()])
        if self.order is not None:
            keep = min(keep, self.order.base)
        if keep > self.first:
            del self.track[:keep - self.first]
            self.first = keep

    def _has_left(self) -> bool:
        """Does a robot that has nothing to drive say that it is somewhere else?"""
        place = place_of(self.pose, self.graph)
        if self.place is None:
            self.place = place
            return False
        if self.place.vertex is not None:
            return place != self.place
        if place is None or place.vertex is not None:
            return place is None or not place.touches(self.graph, (self.place.edge,))
        return abs(place.edge) != abs(self.place.edge)
