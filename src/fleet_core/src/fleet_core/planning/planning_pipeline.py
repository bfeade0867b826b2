"""The planning pipeline: from the robots' present plans to plans that serve all robots.

A valid plan is never dropped before a better one is found. The steps are:

1. Each robot without a path looks for a path past the kept plans of all others. Robots that stand
   idle in its way are asked to make room.
2. If that fails, all robots are planned anew by TEA*.
3. If that fails, too, LaCAM searches over configurations.
4. A robot that still has no path keeps its old plan, and the answer names the robots in its way.
5. The remaining time is used to improve the plan.
"""
from __future__ import annotations

import time
from math import inf
from random import Random
from typing import Dict, Iterable, List, Optional, Sequence, Set

from fleet_core.planning.agents import Agent
from fleet_core.planning.explanation import in_the_way, out_of_reach, why_not
from fleet_core.planning.kept_plans import kept_plans
from fleet_core.planning.lacam import search_lacam
from fleet_core.planning.large_neighbourhood_search import LargeNeighbourhoodSearch
from fleet_core.planning.layers import Search
from fleet_core.planning.outcomes import outcome_of
from fleet_core.planning.plans import Plan
from fleet_core.planning.problem import Problem
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.schedule import schedule
from fleet_core.planning.tasks import Obstacle, PlanningOutcome, Task
from fleet_core.planning.tea_star import Path, Paths, TeaStar, by_length, is_too_late

_ORDERS = 10      # maximum number of orders in which all robots are planned before LaCAM begins
_ROOM_ORDERS = 4  # maximum number of orders if only a robot and the robots in its way are planned
_QUICKLY_BOOKED = 20000  # number of drives that can be booked quickly after the time limit
_TO_EXPLAIN = 0.05  # s after the time limit, for the search for the robots in the way
# The time reserved for making the last outcome: _TO_FINISH s, plus _SLOWER times the time that the
# first outcome took
_TO_FINISH = 0.002
_SLOWER = 1.5
# maximum number of steps of LaCAM if there is no deadline
_MOST_STEPS = 3000


class PlanningPipeline:
    """One run of the planner.

    The attributes are the plans, bookings and reasons on which all steps of the run work.

    reservations -- the reservation table, in which nothing is booked yet
    tasks, obstacles, parking, reserved -- the planner's input
    search     -- the search for one robot's path
    random     -- the source of all random choices
    shuffles   -- whether the first order in which robots are planned is random
    """

    def __init__(self, reservations: ReservationTable, tasks: Sequence[Task],
                 obstacles: Sequence[Obstacle], parking: Iterable[int], search: Search,
                 random: Random, shuffles: bool = False,
                 reserved: Iterable[int] = ()) -> None:
        self._network = reservations.network
        self._reservations = reservations
        self._tea_star = TeaStar(reservations, search)
        self._random = random
        self._shuffles = shuffles
        for obstacle in obstacles:
            self._reservations.book_places(obstacle.name, obstacle.type, [
                *(self._network.index[id] for id in obstacle.vertices),
                *(self._network.vertices + self._network.edge_index[abs(id)]
                  for id in obstacle.edges)], obstacle.areas)
        self._problem = Problem(reservations, tasks, parking, reserved)
        self._agents = self._problem.agents
        self._paths: Paths = {}
        """The paths that serve their robots, all of them booked."""
        self._unserved: Dict[str, str] = {}
        self._old: Dict[str, Plan] = {}
        """The present plans of the robots, with new times."""
        self._unfinished: Paths = {}
        """Paths that were found while all robots were planned anew, before the time was over.

        They are not booked.
        """
        self._grounded: Set[str] = set()
        """Robots that stay where they are."""

    def run(self, deadline: float, rounds: Optional[int], improve_until: float) -> PlanningOutcome:
        """Runs all steps in order, and returns the answer."""
        self._ground_who_is_too_near()
        self._give_up_what_is_out_of_reach()
        self._keep()
        missing = [t for t in self._in_order(self._mobile()) if t.name not in self._paths]
        if missing:
            self._serve(missing, deadline)
        before = time.monotonic()
        outcome = self._outcome(0)
        to_finish = _TO_FINISH + _SLOWER * (time.monotonic() - before)
        mobile = [t for t in self._mobile() if t.name in self._paths]
        neighbourhood_search = LargeNeighbourhoodSearch(self._tea_star, mobile, self._paths,
                                                        self._random)
        neighbourhood_search.run(min(deadline, improve_until) - to_finish, rounds)
        if neighbourhood_search.rounds == 0:
            return outcome
        self._paths = neighbourhood_search.paths
        return self._outcome(neighbourhood_search.rounds)

    def _mobile(self) -> List[Agent]:
        return [t for name, t in self._agents.items() if name not in self._grounded]

    def _in_order(self, agents: Iterable[Agent]) -> List[Agent]:
        """Returns the agents in the order in which they are planned at first."""
        order = by_length(agents)
        if self._shuffles:
            self._random.shuffle(order)
            order.sort(key=lambda t: (-t.priority, not t.query.destinations))
        return order

    # -- present plans ----------------------------------------------------------------------------

    def _ground_who_is_too_near(self) -> None:
        """Grounds robots that stand too near to each other. They block all other robots."""
        for one, other in self._problem.too_near():
            for name, near in ((one, other), (other, one)):
                self._unserved[name] = (f'it stands nearer to {near} than is allowed; move one of '
                                        'them by hand')
                self._grounded.add(name)
        for name in self._grounded:
            self._book_standing(self._agents[name])

    def _give_up_what_is_out_of_reach(self) -> None:
        """Parks robots that cannot reach their destinations even without traffic."""
        for agent in self._mobile():
            if agent.query.lower_bound == inf:
                self._unserved[agent.name] = out_of_reach(self._network, agent)
                self._agents[agent.name] = self._problem.without_destinations(agent)

    def _keep(self) -> None:
        """Books the present plans of the robots, in their present order."""
        mobile = {t.name: t for t in self._mobile()}
        self._old = kept_plans(self._reservations, self._problem.tasks, mobile)
        self._tea_star.book_later([(mobile[name], Path(0.0, plan))
                                   for name, plan in self._old.items()])
        for name, plan in self._old.items():
            cost = mobile[name].query.cost(plan)
            if cost < inf:
                self._paths[name] = Path(cost, plan)

    # -- paths for robots without one -------------------------------------------------------------

    def _serve(self, missing: Sequence[Agent], deadline: float) -> None:
        """Finds paths for these robots. A robot that gets no path is unserved, and keeps its old
        plan if it has one.
        """
        failed = self._serve_each(missing, deadline) if self._old else list(missing)
        if not failed or self._plan_all(failed, self._part_of(deadline, failed)):
            return
        failed = self._serve_somebody(failed, deadline)
        if self._unfinished and not self._paths:
            failed = self._use_unfinished()
        standing = [t for t in failed if t.name not in self._old]
        self._tea_star.forget(standing)
        for agent in standing:
            self._book_standing(agent)
        for agent in failed:
            if agent.name not in self._unserved:
                self._explain(agent, deadline)
        self._stand(standing)

    def _explain(self, agent: Agent, deadline: float) -> None:
        """Notes the reason why a robot has no path."""
        self._tea_star.forget((agent,))
        self._unserved[agent.name] = why_not(self._reservations, agent, deadline + _TO_EXPLAIN)
        if agent.name in self._old:
            self._book_again(agent)
        else:
            self._book_standing(agent)

    def _serve_each(self, missing: Sequence[Agent], deadline: float) -> List[Agent]:
        """Finds paths one by one, past the plans of the others. Returns the robots without a path.
        """
        for agent in missing:
            if agent.name not in self._old:
                self._tea_star.book_present(agent)
        failed = [t for t in missing
                  if t.name not in self._paths and not self._serve_one(t, deadline)]
        # the search for a later robot may have given a path to a robot that had none before
        return [t for t in failed if t.name not in self._paths]

    def _serve_one(self, agent: Agent, deadline: float) -> bool:
        """Finds a path past all plans; if there is none, lets other robots make room.

        Returns whether the robot has a path now.
        """
        self._tea_star.forget((agent,))
        path = self._tea_star.path_of(agent, deadline)
        is_late = is_too_late(deadline, len(path.plan) if path is not None else 0)
        if path is not None and not is_late:
            self._paths[agent.name] = path
            self._tea_star.book(agent, path)
            return True
        if is_late:
            self._book_again(agent)
            return False
        group = [self._making_room(self._agents[name], agent)
                 for name in in_the_way(self._reservations, agent, deadline)
                 if name in self._agents and name not in self._grounded]
        self._tea_star.forget(group)
        paths = self._tea_star.plan([*group, agent], deadline, _ROOM_ORDERS) if group else None
        if paths is None:
            for other in (*group, agent):
                self._book_again(other)
            return False
        self._paths.update(paths)
        self._agents.update((other.name, other) for other in group)
        return True

    def _making_room(self, other: Agent, agent: Agent) -> Agent:
        """Returns `other`, limited to rests that leave the destinations of `agent` free.

        Without such rests `other` is returned unchanged.
        """
        if other.query.rests is None:
            return other
        near = {vertex for destination in agent.query.destinations
                for vertex in self._reservations.blocking[agent.kind, other.kind].excluded(
                    destination)}
        rests = self._problem.rests(other.kind) - near
        return self._problem.with_rests(other, rests) if rests else other

    def _plan_all(self, first: Sequence[Agent], deadline: float) -> bool:
        """Plans all robots anew; those without a path come first. A failure changes nothing."""
        mobile = self._mobile()
        names = {t.name for t in first}
        order = [*first, *(t for t in self._in_order(mobile) if t.name not in names)]
        self._tea_star.forget(order)
        paths = self._tea_star.plan(order, deadline, _ORDERS)
        if not self._paths and not any(self._old.values()):
            found = self._tea_star.unfinished
            few = sum(len(path.plan) for path in found.values()) < _QUICKLY_BOOKED
            self._unfinished = found if few else {}
        if paths is None:
            paths = self._through_configurations(order, deadline)
        if paths is None:
            for agent in order:
                self._book_again(agent)
            return False
        self._paths = paths
        return True

    def _serve_somebody(self, failed: Sequence[Agent], deadline: float) -> List[Agent]:
        """Serves one of these robots; the others only make room for it.

        Returns the robots that are still not served.
        """
        for chosen in failed:
            if time.monotonic() > deadline:
                break
            if not _can_rest_elsewhere(chosen):
                continue
            aside = {t.name: self._problem.without_destinations(t) for t in failed
                     if t is not chosen}
            order = [chosen, *aside.values(),
                     *(t for t in self._mobile() if t.name in self._paths)]
            self._tea_star.forget(order)
            paths = self._tea_star.plan(order, deadline, _ROOM_ORDERS)
            if paths is None:
                paths = self._through_configurations(order, self._part_of(deadline, failed))
            if paths is not None:
                self._old.update((name, paths.pop(name).plan) for name in aside)
                self._agents.update(aside)
                self._paths = paths
                return list(aside.values())
            for agent in order:
                self._book_again(agent)
        return list(failed)

    def _use_unfinished(self) -> List[Agent]:
        """Uses the paths that were found before the time was over.

        Returns the robots without a path.
        """
        self._old.clear()  # these plans are all empty: each robot only stands
        self._paths.update(self._unfinished)
        mobile = self._mobile()
        for agent in mobile:
            self._book_again(agent)
        return [agent for agent in mobile if agent.name not in self._paths]

    @staticmethod
    def _part_of(deadline: float, failed: Sequence[Agent]) -> float:
        """Returns the deadline for a search: `deadline`, or half of the remaining time from now if
        another search can use the other half.
        """
        if deadline == inf or not any(map(_can_rest_elsewhere, failed)):
            return deadline
        return deadline - (deadline - time.monotonic()) / 2.0

    def _through_configurations(self, order: Sequence[Agent],
                                deadline: float) -> Optional[Paths]:
        moves = search_lacam(self._reservations, order, deadline, self._random,
                             inf if deadline < inf else _MOST_STEPS)
        if moves is None:
            return None
        agents = {t.name: t for t in order}
        plans = schedule(self._reservations, agents, moves)
        paths = {name: Path(agents[name].query.cost(plan), plan)
                 for name, plan in plans.items()}
        for name, path in paths.items():
            self._tea_star.book(agents[name], path)
        return paths

    def _stand(self, standing: Sequence[Agent]) -> None:
        """Grounds these robots, and all robots whose plans lead past them."""
        while standing:
            for agent in standing:
                self._grounded.add(agent.name)
                self._paths.pop(agent.name, None)
                self._old.pop(agent.name, None)
                self._tea_star.forget((agent,))
            blocked = {name for agent in standing
                       for name in self._who_passes(agent)} - self._grounded
            for agent in standing:
                self._book_standing(agent)
            standing = [self._agents[name] for name in sorted(blocked)
                        if name in self._agents]
            for agent in standing:
                self._unserved.setdefault(agent.name, 'a robot without a plan is in its way')

    def _who_passes(self, agent: Agent) -> Set[str]:
        """Returns the robots whose plans lead past a standing robot that is not booked."""
        if agent.mid_edge is not None:
            return {robot for robot, _ in self._reservations.passing(agent.kind, agent.mid_edge)}
        slots = self._reservations.slots[agent.kind]
        return {robot for _, _, robot in slots.row(slots.drives + agent.query.vertex)}

    # -- bookings ---------------------------------------------------------------------------------

    def _book_standing(self, agent: Agent) -> None:
        self._tea_star.book(agent, Path(0.0, []))

    def _book_again(self, agent: Agent) -> None:
        """Books the path of a robot; without a path, its old plan; without a plan, its place."""
        self._tea_star.forget((agent,))
        if agent.name in self._paths:
            self._tea_star.book(agent, self._paths[agent.name])
        elif agent.name in self._old:
            self._tea_star.book(agent, Path(0.0, self._old[agent.name]))
        else:
            self._tea_star.book_present(agent)

    def _outcome(self, rounds: int) -> PlanningOutcome:
        behind = {name: self._paths[name].plan if name in self._paths else self._old.get(name, [])
                  for name in self._agents}
        served = [t.name for t in self._agents.values() if t.name in self._paths]
        return outcome_of(self._reservations, self._agents, behind, served, self._unserved, rounds)


def _can_rest_elsewhere(agent: Agent) -> bool:
    """Returns whether the robot has destinations, and need not stay at the last one."""
    return bool(agent.query.destinations) and agent.query.rests is not None
