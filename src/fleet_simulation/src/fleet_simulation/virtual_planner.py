"""The planner of a virtual fleet: the real planner, which answers after a given virtual time."""
from __future__ import annotations

import time
from typing import Dict, List, Optional, Sequence, Tuple

from fleet_core.fleet import Fleet
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.tasks import PlanningOutcome
from fleet_core.supervision.actions import AskPlanner
from fleet_simulation.on_the_way import OnTheWay

_PLANNERS_KEPT = 4  # number of planners, each with its closed edges and learned driving times


class VirtualPlanner:
    """Answers the supervisor's questions. A number of rounds limits its work, not the computing
    time.

    latency -- virtual s until the planner answers
    parking -- ids of the vertices on which robots may be parked; None: all vertices
    """

    def __init__(self, fleet: Fleet, latency: float, parking: Optional[Sequence[int]]) -> None:
        self.latency = latency
        self.rounds = 0
        """Number of rounds in which the planner improves each plan."""
        self.plans: List[float] = []
        """s of processor time that each plan took."""
        self.spent = 0.0
        """s of processor time that all plans took."""
        self._fleet = fleet
        self._parking = None if parking is None else tuple(parking)
        self.answers: OnTheWay[Tuple[int, PlanningOutcome]] = OnTheWay()
        """Answers to the supervisor, with the numbers of its questions."""
        self._planners: Dict[Tuple[frozenset, frozenset], FleetPlanner] = {}

    def forget_graph(self) -> None:
        """Forgets the planners of a graph that is replaced."""
        self._planners.clear()

    def plan(self, question: AskPlanner, network: RoadNetwork) -> PlanningOutcome:
        """Returns the answer to a question on this network."""
        begun = time.thread_time()
        planner = self._planner(question, network)
        outcome = planner.plan(question.tasks, question.obstacles, rounds=self.rounds,
                               seed=question.seed, reserved=question.reserved)
        self.plans.append(time.thread_time() - begun)
        self.spent += self.plans[-1]
        return outcome

    def answer(self, number: int, outcome: PlanningOutcome, now: float) -> None:
        """Sends the answer to question `number`; it arrives after the latency."""
        self.answers.send((number, outcome), now + self.latency)

    def _planner(self, question: AskPlanner, network: RoadNetwork) -> FleetPlanner:
        networks = question.closed, frozenset(question.edge_times.items())
        planner = self._planners.pop(networks, None)
        if planner is None:
            planner = FleetPlanner(
                network.with_closed(question.closed, question.edge_times),
                self._fleet.clearance, (*self._fleet.types, *question.laden),
                tuple(network.graph.vertices) if self._parking is None else self._parking)
            while len(self._planners) >= _PLANNERS_KEPT:
                del self._planners[next(iter(self._planners))]
        self._planners[networks] = planner
        return planner
