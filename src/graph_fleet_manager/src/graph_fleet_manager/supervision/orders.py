"""Orders to one robot, what its reports say of them, and what of both outlives a restart."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import List, Mapping, NamedTuple, Optional, Sequence, Tuple

from graph_fleet_manager.supervision.reports import Place
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


class Memory(NamedTuple):
    """What must outlive a restart; the edges of the record are counted from 0 here."""

    route_id: int
    record: Tuple[int, ...]
    done: int
    bases: Mapping[int, int]
    place: Optional[Place]
    over: bool
    ended: Tuple[int, ...] = ()
    is_stopping: bool = False
    shortened: Optional[int] = None
    """So many edges of the record are left by an order to which there was no answer yet."""
    lost_at: Optional[Place] = None
    """Where it was before it was off the graph, if it is."""

    def on(self, graph: Graph) -> Memory:
        """What of it is true on a graph, maybe another than when this was stored.

        Edges that are driven may be gone: a route that began with them goes on under another id.
        Where more is gone no place is left, but a stop under way is, and which routes are over.
        """
        place, lost_at = (there if there is not None and there.is_on(graph) else None
                          for there in (self.place, self.lost_at))
        if is_on(graph, self.record) and place == self.place:
            return self._replace(lost_at=lost_at)
        # With a full disk more is driven than is stored. What is not driven every new graph has.
        for done in range(self.done, len(self.record)):
            if is_on(graph, self.record[done:]):
                return self._replace(
                    record=self.record[done:], done=0, place=place, lost_at=lost_at, over=True,
                    bases={id: base - done for id, base in self.bases.items()},
                    shortened=None if self.shortened is None else self.shortened - done)
        return self._replace(record=(), done=0, place=None, over=True, shortened=None,
                             lost_at=lost_at, bases={self.route_id: 0} if self.is_stopping else {})


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
