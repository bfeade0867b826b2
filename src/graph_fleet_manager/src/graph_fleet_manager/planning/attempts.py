"""The order of attempts: from what every robot owns by now to plans that serve all of them.

A valid plan is never dropped before a better one stands. First the robots that lack a way look for
one past the kept plans of all others, asking those who merely stand in the way to make room; if
that fails, everybody is planned anew by TEA*, and then by the search over configurations. Who still
has no way keeps its old plan, and it is said who is in its way. What time is left improves the
plan.
"""
from __future__ import annotations

import time
from math import inf
from random import Random
from typing import Dict, Iterable, List, Optional, Sequence, Set

from graph_fleet_manager.planning.configuration_search import search_configurations
from graph_fleet_manager.planning.explanation import in_the_way, out_of_reach, why_not
from graph_fleet_manager.planning.kept_plans import kept_plans
from graph_fleet_manager.planning.layers import Search
from graph_fleet_manager.planning.neighbourhoods import Improvement
from graph_fleet_manager.planning.outcomes import outcome_of
from graph_fleet_manager.planning.plans import Plan
from graph_fleet_manager.planning.problem import Problem
from graph_fleet_manager.planning.schedule import schedule
from graph_fleet_manager.planning.tasks import Obstacle, Outcome, Task
from graph_fleet_manager.planning.tea_star import TeaStar, Way, Ways, by_length
from graph_fleet_manager.planning.timetable import Timetable
from graph_fleet_manager.planning.travellers import Traveller

_ORDERS = 10      # in which all are planned anew before the search over configurations begins
_ROOM_ORDERS = 4  # in which a robot and those in its way are planned
_TO_FINISH = 0.002  # s that are left at the end, and so many times what an outcome took before:
_SLOWER = 1.5


class Attempts:
    """One run of the planner.

    timetable  -- in which nothing is booked yet
    tasks, obstacles, parking -- as the planner was asked
    search     -- for one robot's way
    random     -- what chance decides
    """

    def __init__(self, timetable: Timetable, tasks: Sequence[Task], obstacles: Sequence[Obstacle],
                 parking: Iterable[int], search: Search, random: Random) -> None:
        self._network = timetable.network
        self._timetable = timetable
        self._tea_star = TeaStar(timetable, search)
        self._random = random
        for obstacle in obstacles:
            self._timetable.book_places(obstacle.name, obstacle.type, [
                *(self._network.index[id] for id in obstacle.vertices),
                *(self._network.vertices + self._network.edge_index[abs(id)]
                  for id in obstacle.edges)])
        self._problem = Problem(timetable, tasks, parking)
        self._travellers = self._problem.travellers
        self._ways: Ways = {}
        """The ways that serve, all of them booked."""
        self._unserved: Dict[str, str] = {}
        self._old: Dict[str, Plan] = {}
        """Plans owned by now, with new times."""
        self._grounded: Set[str] = set()
        """Robots that stay where they are."""

    def run(self, deadline: float, rounds: Optional[int], improve_until: float) -> Outcome:
        """Everything in its order."""
        self._ground_who_is_too_near()
        self._give_up_what_is_out_of_reach()
        self._keep()
        missing = [t for t in by_length(self._movers()) if t.name not in self._ways]
        if missing:
            self._serve(missing, deadline)
        before = time.monotonic()
        outcome = self._outcome(0)
        to_finish = _TO_FINISH + _SLOWER * (time.monotonic() - before)
        movers = [t for t in self._movers() if t.name in self._ways]
        improvement = Improvement(self._tea_star, movers, self._ways, self._random)
        improvement.run(min(deadline, improve_until) - to_finish, rounds)
        if improvement.rounds == 0:
            return outcome
        self._ways = improvement.ways
        return self._outcome(improvement.rounds)

    def _movers(self) -> List[Traveller]:
        return [t for name, t in self._travellers.items() if name not in self._grounded]

    # -- what is there already --------------------------------------------------------------------

    def _ground_who_is_too_near(self) -> None:
        """Robots that stand too near each other stay where they are, in everybody's way."""
        for one, other in self._problem.too_near():
            for name, near in ((one, other), (other, one)):
                self._unserved[name] = (f'it stands nearer to {near} than is allowed; move one of '
                                        'them by hand')
                self._grounded.add(name)
        for name in self._grounded:
            self._book_standing(self._travellers[name])

    def _give_up_what_is_out_of_reach(self) -> None:
        """Who cannot get where it is to go, even alone, is only parked."""
        for traveller in self._movers():
            if traveller.errand.lower_bound == inf:
                self._unserved[traveller.name] = out_of_reach(self._network, traveller)
                self._travellers[traveller.name] = self._problem.without_destinations(traveller)

    def _keep(self) -> None:
        """Books the plans that robots own, in the order in which they were to be driven."""
        movers = {t.name: t for t in self._movers()}
        self._old = kept_plans(self._timetable, self._problem.tasks, movers)
        for name, plan in self._old.items():
            self._tea_star.book(movers[name], Way(0.0, plan))
            cost = movers[name].errand.cost(plan)
            if cost < inf:
                self._ways[name] = Way(cost, plan)

    # -- ways for those who have none -------------------------------------------------------------

    def _serve(self, missing: Sequence[Traveller], deadline: float) -> None:
        """Finds ways for these; who gets none is unserved, and keeps its old plan if it has one."""
        failed = list(missing)
        if self._old:
            for traveller in missing:
                if traveller.name not in self._old:
                    self._tea_star.book_present(traveller)
            failed = [t for t in missing
                      if t.name not in self._ways and not self._serve_one(t, deadline)]
            failed = [t for t in failed if t.name not in self._ways]  # nor got one with another
        if not failed or self._plan_all(failed, self._part_of(deadline, failed)):
            return
        failed = self._serve_somebody(failed, deadline)
        standing = [t for t in failed if t.name not in self._old]
        self._tea_star.forget(standing)
        for traveller in standing:
            self._book_standing(traveller)
        for traveller in failed:
            if traveller.name not in self._unserved:
                self._tea_star.forget((traveller,))
                self._unserved[traveller.name] = why_not(self._timetable, traveller)
                if traveller.name in self._old:
                    self._book_again(traveller)
                else:
                    self._book_standing(traveller)
        self._stand(standing)

    def _serve_one(self, traveller: Traveller, deadline: float) -> bool:
        """A way past everybody's plans, or past those that make room."""
        self._tea_star.forget((traveller,))
        way = self._tea_star.way_of(traveller)
        if way is not None:
            self._ways[traveller.name] = way
            self._tea_star.book(traveller, way)
            return True
        group = [self._making_room(self._travellers[name], traveller)
                 for name in in_the_way(self._timetable, traveller)
                 if name in self._travellers and name not in self._grounded]
        self._tea_star.forget(group)
        ways = self._tea_star.plan([*group, traveller], deadline, _ROOM_ORDERS) if group else None
        if ways is None:
            for other in (*group, traveller):
                self._book_again(other)
            return False
        self._ways.update(ways)
        self._travellers.update((other.name, other) for other in group)
        return True

    def _making_room(self, other: Traveller, traveller: Traveller) -> Traveller:
        """One who is in the way, that must end where it leaves the other's destinations free."""
        if other.errand.rests is None:
            return other
        near = {vertex for destination in traveller.errand.destinations
                for vertex in self._timetable.blocking[traveller.kind, other.kind].excluded(
                    destination)}
        rests = self._problem.rests(other.kind) - near
        return self._problem.with_rests(other, rests) if rests else other

    def _plan_all(self, first: Sequence[Traveller], deadline: float) -> bool:
        """Everybody anew; those who lacked a way come first. Nothing changes where that fails."""
        movers = self._movers()
        names = {t.name for t in first}
        order = [*first, *(t for t in by_length(movers) if t.name not in names)]
        self._tea_star.forget(order)
        ways = self._tea_star.plan(order, deadline, _ORDERS)
        if ways is None:
            ways = self._through_configurations(order, deadline)
        if ways is None:
            for traveller in order:
                self._book_again(traveller)
            return False
        self._ways = ways
        return True

    def _serve_somebody(self, failed: Sequence[Traveller], deadline: float) -> List[Traveller]:
        """One of these, for whom all others without a way only make room; returns who is left."""
        for chosen in failed:
            if not _can_rest_elsewhere(chosen):
                continue
            aside = {t.name: self._problem.without_destinations(t) for t in failed
                     if t is not chosen}
            order = [chosen, *aside.values(),
                     *(t for t in self._movers() if t.name in self._ways)]
            self._tea_star.forget(order)
            ways = self._tea_star.plan(order, deadline, _ROOM_ORDERS)
            if ways is None:
                ways = self._through_configurations(order, self._part_of(deadline, failed))
            if ways is not None:
                self._old.update((name, ways.pop(name).plan) for name in aside)
                self._travellers.update(aside)
                self._ways = ways
                return list(aside.values())
            for traveller in order:
                self._book_again(traveller)
            if time.monotonic() > deadline:
                break
        return list(failed)

    @staticmethod
    def _part_of(deadline: float, failed: Sequence[Traveller]) -> float:
        """Half of the time that is left, where something else can be tried in the other half."""
        if deadline == inf or not any(map(_can_rest_elsewhere, failed)):
            return deadline
        return deadline - (deadline - time.monotonic()) / 2.0

    def _through_configurations(self, order: Sequence[Traveller],
                                deadline: float) -> Optional[Ways]:
        if any(t.between for t in order):
            return None
        moves = search_configurations(self._timetable, order, deadline, self._random)
        if moves is None:
            return None
        travellers = {t.name: t for t in order}
        plans = schedule(self._timetable, travellers, moves)
        ways = {name: Way(travellers[name].errand.cost(plan), plan)
                for name, plan in plans.items()}
        for name, way in ways.items():
            self._tea_star.book(travellers[name], way)
        return ways

    def _stand(self, standing: Sequence[Traveller]) -> None:
        """These stay where they are, and with them all whose plans lead past them."""
        while standing:
            for traveller in standing:
                self._grounded.add(traveller.name)
                self._ways.pop(traveller.name, None)
                self._old.pop(traveller.name, None)
                self._tea_star.forget((traveller,))
            blocked = {name for traveller in standing
                       for name in self._who_passes(traveller)} - self._grounded
            for traveller in standing:
                self._book_standing(traveller)
            standing = [self._travellers[name] for name in sorted(blocked)
                        if name in self._travellers]
            for traveller in standing:
                self._unserved.setdefault(traveller.name, 'somebody without a plan is in its way')

    def _who_passes(self, traveller: Traveller) -> Set[str]:
        """Whose plans lead past the place at which a robot stands, which is not booked."""
        slots = self._timetable.slots[traveller.kind]
        if traveller.between is None:
            places = [slots.drives + traveller.errand.vertex]
        else:
            places = [traveller.between.drive, traveller.between.drive ^ 1]
        return {robot for slot in places for _, _, robot in slots.bookings[slot]}

    # -- bookings ---------------------------------------------------------------------------------

    def _book_standing(self, traveller: Traveller) -> None:
        self._tea_star.book(traveller, Way(0.0, []))

    def _book_again(self, traveller: Traveller) -> None:
        """The way that a robot has, or else its old plan, or else only where it is."""
        self._tea_star.forget((traveller,))
        if traveller.name in self._ways:
            self._tea_star.book(traveller, self._ways[traveller.name])
        elif traveller.name in self._old:
            self._tea_star.book(traveller, Way(0.0, self._old[traveller.name]))
        else:
            self._tea_star.book_present(traveller)

    def _outcome(self, rounds: int) -> Outcome:
        behind = {name: self._ways[name].plan if name in self._ways else self._old.get(name, [])
                  for name in self._travellers}
        served = [t.name for t in self._travellers.values() if t.name in self._ways]
        return outcome_of(self._timetable, self._travellers, behind, served, self._unserved, rounds)


def _can_rest_elsewhere(traveller: Traveller) -> bool:
    """Has it something to do, and need not stay there?"""
    return bool(traveller.errand.destinations) and traveller.errand.rests is not None
