"""Orders to one robot, what its reports say of them, and what of both outlives a restart."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import List, Mapping, NamedTuple, Optional, Sequence, Tuple

from graph_fleet_manager.interlocking.evidence import EvidenceMemory
from graph_fleet_manager.interlocking.reports import GraphPosition
from trajectory_graph import Graph, TrajectoryGraphError, check_route
from trajectory_graph.route_protocol import NO_REASON, Reason


class Order(NamedTuple):
    """A route as sent to the robot: the edges of the record from `base` on."""

    route_id: int
    base: int
    edges: Tuple[int, ...]

    @property
    def end(self) -> int:
        """Number, in the record, behind its last edge."""
        return self.base + len(self.edges)


class Sending(NamedTuple):
    """An order to be sent now; a repeated one goes out exactly as before."""

    route_id: int
    edges: Tuple[int, ...]
    repeated: bool = False
    known_epoch: int = 0


class Memory(NamedTuple):
    """What must outlive a restart; the edges of the record are counted from 0 here."""

    route_id: int
    edges: Tuple[int, ...]
    done: int
    bases: Mapping[int, int]
    position: Optional[GraphPosition]
    over: bool
    ended: Tuple[int, ...] = ()
    is_stopping: bool = False
    shortened: Optional[int] = None
    """So many edges of the record are left by an order to which there was no answer yet."""
    cleared: Tuple[int, float] = (0, 0.0)
    """Edge and fraction that certainly lie behind the robot."""
    tail: Tuple[int, ...] = ()
    """Edges that were taken back, but may be reached before it stands."""
    evidence: EvidenceMemory = EvidenceMemory()
    stamp: float = 0.0
    """Of the last report, s by the robot's clock: reports from before it tell nothing."""
    withdrawn: Optional[int] = None
    """Id of an order that is not given any more, but may reach the robot yet."""
    acknowledged: Tuple[int, ...] = ()
    """Ids of the routes that the robot has taken up."""

    @property
    def held(self) -> Tuple[int, ...]:
        """All edges that the robot may be on, signed."""
        return (*self.edges[self.cleared[0]:], *self.tail, *self.evidence.foreign)

    def on(self, graph: Graph) -> Memory:
        """What of it is true on a graph, maybe another than when this was stored.

        Edges that are driven may be gone: a route that began with them goes on under another id.
        Where more is gone no position is left, but a stop under way is, and which routes are over.
        """
        position = self.position
        if position is not None and not position.is_on(graph):
            position = None
        kept = self._replace(position=position, tail=tuple(
            edge for edge in self.tail if abs(edge) in graph.edges))
        if is_on(graph, self.edges) and position == self.position:
            return kept
        # With a full disk more is driven than is stored. What is not driven every new graph has.
        for done in range(min(self.cleared[0], self.done), len(self.edges)):
            if is_on(graph, self.edges[done:]):
                return kept._replace(
                    edges=self.edges[done:], done=max(self.done - done, 0), over=True,
                    bases={id: base - done for id, base in self.bases.items()},
                    shortened=None if self.shortened is None else self.shortened - done,
                    cleared=max((self.cleared[0] - done, self.cleared[1]), (0, 0.0)))
        return kept._replace(edges=(), done=0, position=None, over=True, shortened=None,
                             cleared=(0, 0.0), bases={self.route_id: 0} if self.is_stopping else {})


@dataclass
class Heard:
    """What a report told.

    passed  -- vertices passed since the last report, in order
    failed  -- why the route failed; no reason: it did not
    refused -- why an order was not taken up; no reason: it was
    was_shorter -- that order was to end the route sooner
    foreign -- the robot drives a route that it was not given here
    left    -- nothing is to be driven, but the robot is not where its route ended
    """

    passed: List[int] = field(default_factory=list)
    failed: Reason = NO_REASON
    refused: Reason = NO_REASON
    was_shorter: bool = False
    foreign: bool = False
    left: bool = False


def is_on(graph: Graph, edges: Sequence[int]) -> bool:
    """Can a route over these edges be driven on this graph?"""
    try:
        check_route(graph, edges)
    except TrajectoryGraphError:
        return False
    return True
