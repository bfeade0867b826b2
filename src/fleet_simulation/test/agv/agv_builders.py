"""AGVs for several tests, and an object that records their messages."""
from __future__ import annotations

from random import Random
from typing import Callable, List, Optional, Sequence

from fleet_builders import graph_of

from fleet_simulation.agv.vehicle import AgvVehicle
from route_protocol.values import RouteOrder, RouteRefusal, RouteReport
from trajectory_graph import Graph

TICK = 0.1
#: Vertices 1 - 2 - 3 - 4 in a row, 4 m apart, and vertex 5 beside 2.
GRAPH = graph_of({1: (0, 0), 2: (4, 0), 3: (8, 0), 4: (12, 0), 5: (4, 4)},
                 {1: (1, 2), 2: (2, 3), 3: (3, 4), 4: (2, 5)})


def vehicle_at(vertex: int, graph: Graph = GRAPH, clock: Callable[[], int] = lambda: 0,
               **options: object) -> AgvVehicle:
    """Returns an AGV with random epochs."""
    return AgvVehicle('agv_1', graph, vertex, numbers_of_epochs(), clock, **options)


def numbers_of_epochs(seed: int = 1) -> Callable[[], int]:
    """Returns a function that draws the numbers of new epochs."""
    random = Random(seed)
    return lambda: random.getrandbits(63) or 1


class Conversation:
    """An AGV and its messages."""

    def __init__(self, vertex: int = 1, graph: Graph = GRAPH, **options: object) -> None:
        self.reports: List[RouteReport] = []
        self.refusals: List[RouteRefusal] = []
        self._stamp = 0
        self.vehicle = vehicle_at(vertex, graph, lambda: self._stamp // 1_000_000, **options)

    def order(self, route_id: int, *edges: int, stamp: int = 0) -> None:
        self.vehicle.handle(RouteOrder(route_id, edges, stamp))
        self._listen()

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK)):
            self._stamp += int(TICK * 1e9)
            self.vehicle.advance(TICK, self._stamp)
            self._listen()

    def drive_to(self, place: float) -> None:
        """Runs the AGV until it has driven to the given x, in m."""
        while self.vehicle.pose[0] < place:
            self.wait(TICK)

    @property
    def last(self) -> RouteReport:
        return self.vehicle.report()

    def states(self) -> Sequence[int]:
        return [int(state) for state in self.last.states]

    @property
    def reason(self) -> Optional[str]:
        """The reason why the last order was refused."""
        return self.refusals[-1].reason.text if self.refusals else None

    def _listen(self) -> None:
        for message in self.vehicle.new_messages():
            if isinstance(message, RouteReport):
                self.reports.append(message)
            else:
                self.refusals.append(message)
