"""Orders to one robot, the results of its reports, and the state to keep over a restart."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import List, Mapping, NamedTuple, Optional, Sequence, Tuple

from graph_fleet_manager.interlocking.evidence import EvidenceMemory
from graph_fleet_manager.interlocking.reports import GraphPosition
from route_protocol.values import NO_REASON, Reason
from trajectory_graph import Graph, TrajectoryGraphError, check_route


class Order(NamedTuple):
    """A route as sent to the robot: the edges of the record from `base` on."""

    route_id: int
    base: int
    edges: Tuple[int, ...]

    @property
    def end(self) -> int:
        """Number, in the record, of the first edge behind the order's last edge."""
        return self.base + len(self.edges)


class Sending(NamedTuple):
    """An order to be sent now. A repeated order is sent exactly as before."""

    route_id: int
    edges: Tuple[int, ...]
    repeated: bool = False
    known_epoch: int = 0


class Base(NamedTuple):
    """Where a route begins in the route record.

    number -- number of the route's first edge
    before -- number behind the last edge that the robot may drive without this route; it may lie
              behind the end of the record, if edges were taken back since
    """

    number: int
    before: int

    def moved(self, by: int) -> Base:
        """The same base in a record that counts its edges from another number on."""
        return Base(self.number + by, self.before + by)


class Memory(NamedTuple):
    """The state of a route client that must survive a restart. Edges are counted from 0 here."""

    route_id: int
    edges: Tuple[int, ...]
    done: int
    bases: Mapping[int, Base]
    position: Optional[GraphPosition]
    over: bool
    ended: Tuple[int, ...] = ()
    is_stopping: bool = False
    shortened: Optional[int] = None
    """Number of edges that are left by a shortening order which is not yet acknowledged."""
    cleared: Tuple[int, float] = (0, 0.0)
    """Edge and fraction that certainly lie behind the robot."""
    tail: Tuple[int, ...] = ()
    """Edges that were taken back, but that the robot may still reach before it stands."""
    evidence: EvidenceMemory = EvidenceMemory()
    stamp: float = 0.0
    """Stamp of the last report, in s by the robot's clock. Earlier reports are ignored."""
    withdrawn: Optional[int] = None
    """Id of an order that was withdrawn, but may still reach the robot."""
    acknowledged: Tuple[int, ...] = ()
    """Ids of the routes that the robot has taken up."""

    @property
    def ids(self) -> Tuple[int, ...]:
        """The ids of the last routes that the robot was given."""
        return (self.route_id, *self.bases, *self.ended)

    @property
    def held(self) -> Tuple[int, ...]:
        """All edges that the robot may be on, signed."""
        return (*self.edges[self.cleared[0]:], *self.tail, *self.evidence.foreign)

    def on(self, graph: Graph) -> Memory:
        """The part of this state that is valid on a graph, which may differ from the stored one.

        - If only edges are missing that the robot has driven, the record begins behind them, and
          the next order gets another route id.
        - If more edges are missing, no position is kept. A stop under way is kept.
        - The ids of routes that are over are kept in both cases.
        """
        position = self.position
        if position is not None and not position.is_on(graph):
            position = None
        kept = self._replace(position=position, tail=tuple(
            edge for edge in self.tail if abs(edge) in graph.edges))
        if is_on(graph, self.edges) and position == self.position:
            return kept
        # With a full disk the robot may have driven more edges than are stored. Each new graph has
        # all edges that are not driven yet.
        for done in range(min(self.cleared[0], self.done), len(self.edges)):
            if is_on(graph, self.edges[done:]):
                return kept._replace(
                    edges=self.edges[done:], done=max(self.done - done, 0), over=True,
                    bases={id: base.moved(-done) for id, base in self.bases.items()},
                    shortened=None if self.shortened is None else self.shortened - done,
                    cleared=max((self.cleared[0] - done, self.cleared[1]), (0, 0.0)))
        bases = {self.route_id: Base(0, 0)} if self.is_stopping else {}
        return kept._replace(edges=(), done=0, position=None, over=True, shortened=None,
                             cleared=(0, 0.0), bases=bases)


@dataclass
class Heard:
    """The results of one report.

    passed  -- vertices passed since the last report, in order
    failed  -- why the route failed; no reason: it did not fail
    refused -- why the robot refused an order; no reason: it refused none
    was_shorter -- the refused order was one that stops the robot or shortens its route
    foreign -- the robot drives a route that it was not given here
    left    -- the robot has nothing to drive, but is not where its route ended
    is_located -- the report has a later location than all before
    """

    passed: List[int] = field(default_factory=list)
    failed: Reason = NO_REASON
    refused: Reason = NO_REASON
    was_shorter: bool = False
    foreign: bool = False
    left: bool = False
    is_located: bool = False


def is_on(graph: Graph, edges: Sequence[int]) -> bool:
    """Can a route over these edges be driven on this graph?"""
    try:
        check_route(graph, edges)
    except TrajectoryGraphError:
        return False
    return True
