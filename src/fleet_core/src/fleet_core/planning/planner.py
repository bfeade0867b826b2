"""The planner of a fleet: plans again and again on one graph."""
from __future__ import annotations

import gc
from contextlib import contextmanager
from math import inf
from random import Random
from typing import Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

from fleet_core.fleet import RobotType
from fleet_core.planning.layers import Search
from fleet_core.planning.planning_pipeline import PlanningPipeline
from fleet_core.planning.problem import check
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.tasks import Obstacle, PlanningOutcome, Task

Place = Tuple[str, RobotType, int]
"""Name of a robot, its type, and the id of a vertex."""


class FleetPlanner:
    """Plans for all robots of a fleet on one graph.

    `plan` runs the planning pipeline once. The planner keeps the reservation table of its graph
    from run to run, but no state of the fleet.

    network   -- the graph, with the edges that are closed now
    clearance -- m between any two robots
    kinds     -- all robot types that will occur
    parking   -- ids of the vertices at which robots may be parked
    search    -- the search for one robot's path: `safe_intervals.find_path` or `layers.layered`
    seed      -- for all random choices
    """

    def __init__(self, network: RoadNetwork, clearance: float, kinds: Iterable[RobotType],
                 parking: Iterable[int] = (), search: Search = find_path, seed: int = 0) -> None:
        self.network = network
        self.reservations = ReservationTable(network, clearance, kinds)
        self.parking = tuple(parking)
        self._search = search
        self._seed = seed

    def prepare(self) -> None:
        """Computes in advance what depends only on the graph."""
        with _without_garbage_collection():
            self.reservations.prepare()

    def too_near(self, places: Sequence[Place]) -> Optional[Tuple[Place, Place]]:
        """Returns two of these robots that may not stand at their vertices at the same time.

        None: all of them may.
        """
        at: Dict[int, List[Place]] = {}
        for place in places:
            vertex = self.network.index[place[2]]
            for other_kind in self.reservations.kinds:
                for near in self.reservations.blocking[place[1], other_kind].excluded(vertex):
                    for other in at.get(near, ()):
                        if other[1] == other_kind:
                            return other, place
            if vertex in at:
                return at[vertex][0], place
            at.setdefault(vertex, []).append(place)
        return None

    def can_park(self, ends: Sequence[Place], others: Sequence[Place]) -> bool:
        """Returns whether all `others` can park while the robots at `ends` stay there."""
        for kind in {place[1] for place in others}:
            taken = {vertex for _, end_kind, id in ends
                     for vertex in self.reservations.blocking[end_kind, kind].excluded(
                         self.network.index[id])}
            free = set(range(self.network.vertices)) - taken
            free -= self.network.docks - {self.network.index[place[2]] for place in others}
            if len(free) < sum(place[1] == kind for place in others):
                return False
        return True

    def plan(self, tasks: Sequence[Task], obstacles: Sequence[Obstacle] = (),
             deadline: float = inf, rounds: Optional[int] = None,
             improve_until: float = inf, seed: int = 0,
             reserved: Iterable[int] = ()) -> PlanningOutcome:
        """Plans for all tasks, and improves the plans.

        The improvement ends at the deadline (monotonic s), after `rounds`, or at `improve_until`
        (monotonic s), whichever comes first. A `seed` of 0 stands for the planner's own seed. With
        any other seed the first order in which robots are planned is random. No robot is parked at
        the vertices `reserved` if there is enough other parking.

        Raises CannotPlan for an invalid task.
        """
        check(self.network, tasks)
        with _without_garbage_collection():
            try:
                return PlanningPipeline(
                    self.reservations, tasks, obstacles, self.parking, self._search,
                    Random(seed or self._seed), seed != 0, reserved,
                ).run(deadline, rounds, improve_until)
            finally:
                self.reservations.clear()


@contextmanager
def _without_garbage_collection() -> Iterator[None]:
    """Suspends garbage collection.

    Plans and blocks are many small values without cycles. Collecting garbage would only cost time.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
