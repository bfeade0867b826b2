"""Makes the planner's answer from the final plans."""
from __future__ import annotations

from typing import Iterable, Mapping

from fleet_core.planning.agents import Agent
from fleet_core.planning.plans import Plan
from fleet_core.planning.precedence import precedence
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.schedule import in_order, schedule
from fleet_core.planning.tasks import PlannedDrive, PlanningOutcome


def outcome_of(reservations: ReservationTable, agents: Mapping[str, Agent],
               behind: Mapping[str, Plan], served: Iterable[str], unserved: Mapping[str, str],
               rounds: int) -> PlanningOutcome:
    """Returns the plans, and the order of use that keeps them safe.

    behind   -- for each agent, the plan after its fixed drives
    served   -- agents whose plans lead to all of their destinations
    unserved -- the other agents, each with the reason
    rounds   -- number of rounds of improvement; above 0: the drives get the earliest times that
                the order allows
    """
    ids = reservations.network.signed_ids
    plans = schedule(reservations, agents, in_order(behind)) if rounds else behind
    whole = {name: agents[name].whole(plan) for name, plan in plans.items()}
    constraints = precedence(reservations, whole, {name: t.kind for name, t in agents.items()},
                             {name: len(t.fixed) for name, t in agents.items()})
    queries = {name: agents[name].query for name in served}
    return PlanningOutcome(
        {name: tuple([PlannedDrive(ids[drive], start, end) for drive, start, end, _ in plan])
         for name, plan in whole.items()},
        tuple(constraints), dict(unserved),
        sum(query.cost(plans[name]) for name, query in queries.items()),
        sum(query.lower_bound for query in queries.values()), rounds)
