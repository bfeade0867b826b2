"""Large neighbourhood search: improves plans in the remaining time.

In each round some robots that are in each other's way are planned again in another order. Their new
paths are kept if together they cost less than the old ones, or only a little more. A slightly
higher cost is accepted so that the search can leave a local optimum. (Li et al., Anytime
multi-agent path finding via large neighborhood search, IJCAI 2021.)

In some rounds the first of these robots is planned twice: first as a guest, which blocks the others
only until shortly after its arrival, and a second time after all others. So two robots can pass
each other even if the destination of each robot lies on the only path of the other.
"""
from __future__ import annotations

import time
from math import inf, log
from random import Random
from typing import Dict, List, Mapping, Optional, Sequence, Set

from fleet_core.planning.agents import Agent
from fleet_core.planning.plans import end_of
from fleet_core.planning.tea_star import Path, Paths, TeaStar, shuffled

_SMALLEST, _LARGEST = 2, 8
_GUESTS = 0.2  # share of the rounds that plan one robot twice
_GUEST_STAYS = 10.0  # s, at most, that a guest stays at its end
_WORSE = 0.01  # average rise of the cost that is accepted, as a share of all delays
_CLOSE = 1e-9  # relative difference below which two costs count as equal
_MEMORY = 0.9  # weight of the past when the choice among the kinds of neighbourhoods is updated


class LargeNeighbourhoodSearch:
    """Improves the paths of agents that are all booked in `tea_star`'s reservation table.

    movable -- names of the agents that may be planned again; the others keep their paths
    """

    def __init__(self, tea_star: TeaStar, agents: Sequence[Agent], paths: Mapping[str, Path],
                 random: Random, movable: Optional[Set[str]] = None) -> None:
        self._tea_star = tea_star
        self._random = random
        self._all: Dict[str, Agent] = {t.name: t for t in agents}
        self._movable: List[str] = [t.name for t in agents
                                    if movable is None or t.name in movable]
        self._movable_set = set(self._movable)
        self._now: Paths = dict(paths)
        """The booked paths."""
        self.paths: Paths = dict(paths)
        """The best paths so far."""
        self.rounds = 0
        """Number of neighbourhoods that were tried."""
        self._weights = [1.0] * len(_KINDS)

    def delay(self, name: str) -> float:
        """Returns the cost of the booked path minus the robot's lowest cost without traffic."""
        return self._now[name].cost - self._all[name].query.lower_bound

    def run(self, deadline: float, rounds: Optional[int] = None) -> None:
        """Improves the plans until the deadline (monotonic s), for `rounds` rounds, or until no
        robot has a delay.
        """
        cost = best = sum(path.cost for path in self._now.values())
        while len(self._movable) > 0 and (rounds is None or self.rounds < rounds):
            if time.monotonic() >= deadline:
                break
            delays = sum(map(self.delay, self._movable))
            if delays <= _CLOSE * cost:
                break
            self.rounds += 1
            kind = self._random.choices(range(len(_KINDS)), self._weights)[0]
            more = -_WORSE * delays * log(1.0 - self._random.random())  # exponentially distributed
            gain = self._try(_KINDS[kind](self), more, deadline)
            gained = max(gain, 0.0)
            self._weights[kind] = max(_MEMORY * self._weights[kind] + (1 - _MEMORY) * gained, 1e-3)
            cost -= gain
            if cost < best * (1.0 - _CLOSE):
                best, self.paths = cost, dict(self._now)

    def _try(self, names: Sequence[str], more: float, deadline: float) -> float:
        """Plans these robots again together. Returns how much less the new paths cost.

        The new paths may cost more than the old ones, but at most `more`.
        """
        group = shuffled((self._all[name] for name in names), self._random)
        before = sum(self._now[name].cost for name in names)
        enough = before * (1.0 - _CLOSE) + more
        taken = self._tea_star.reservations.take_out(names)
        for agent in group:
            if agent.fixed or agent.mid_edge or agent.query.ready > 0.0:
                self._tea_star.book_fixed(agent)
        if group[0].priority == group[-1].priority and self._random.random() < _GUESTS:
            guest = group.pop(0)
            self._book_guest(guest, deadline)
            group.append(guest)
        least = sum(t.query.lower_bound for t in group)
        spent, found = 0.0, {}
        for agent in group:
            least -= agent.query.lower_bound
            self._tea_star.forget((agent,))
            path = self._tea_star.path_of(agent, deadline, enough - spent - least)
            if path is None or time.monotonic() >= deadline:
                self._tea_star.reservations.put_back(taken)
                return 0.0
            found[agent.name] = path
            spent += path.cost
            self._tea_star.book(agent, path)
        self._now.update(found)
        return before - spent

    def _book_guest(self, agent: Agent, deadline: float) -> None:
        """Books the best path of a robot, with only a short stay at its end."""
        self._tea_star.forget((agent,))
        path = self._tea_star.path_of(agent, deadline)
        if path is None:
            self._tea_star.book_fixed(agent)
        else:
            leaves = end_of(agent.whole(path.plan)) + self._random.uniform(0.0, _GUEST_STAYS)
            self._tea_star.book(agent, path, leaves)

    # -- neighbourhoods ---------------------------------------------------------------------------

    def _size(self) -> int:
        return min(self._random.randint(_SMALLEST, _LARGEST), len(self._movable))

    def _any(self) -> List[str]:
        return self._random.sample(self._movable, self._size())

    def _around_delayed(self) -> List[str]:
        """Returns a delayed robot, and the robots that it meets on its shortest path."""
        delays = [max(self.delay(name), 0.0) for name in self._movable]
        if sum(delays) <= 0.0:
            return self._any()
        name = self._random.choices(self._movable, delays)[0]
        return self._filled([name, *self._met_by(self._all[name])])

    def _around_place(self) -> List[str]:
        """Returns a robot, and the robots that block one drive of its plan at other times."""
        name = self._random.choice(self._movable)
        plan = self._now[name].plan
        if not plan:
            return self._any()
        drive = self._random.choice(plan).drive
        slots = self._tea_star.reservations.slots[self._all[name].kind]
        users = {robot for _, _, robot in slots.row(drive)} - {name}
        return self._filled([name, *sorted(users)])

    def _met_by(self, agent: Agent) -> List[str]:
        """Returns the robots that an agent would meet if it left its plan at a random vertex and
        took the shortest path.
        """
        query = agent.query
        if not query.destinations:
            return []
        slots = self._tea_star.reservations.slots[agent.kind]
        to_go = query.to_go[len(query.destinations) - 1]
        plan = self.paths[agent.name].plan
        start = self._random.randint(1 if agent.mid_edge else 0, len(plan)) if plan else 0
        vertex, now = query.vertex, query.ready
        if start:
            last = plan[start - 1]
            vertex = self._tea_star.reservations.network.destination(last.drive)
            now = last.end
        met: Dict[str, None] = {}
        while to_go[vertex] > 0.0 and len(met) < _LARGEST:
            roads = query.roads[vertex]
            if not roads:
                break
            cost, drive, end, seconds = min(
                (seconds + to_go[end], drive, end, seconds) for drive, end, seconds in roads)
            if cost == inf:
                break
            for begin, over, robot in slots.row(drive):
                if begin < now < over and robot != agent.name:
                    met[robot] = None
            vertex, now = end, now + seconds
        return list(met)

    def _filled(self, names: Sequence[str]) -> List[str]:
        """Returns as many robots as a neighbourhood has: movable ones of `names`, then other ones
        at random.
        """
        size = self._size()
        chosen = [name for name in dict.fromkeys(names) if name in self._movable_set][:size]
        while len(chosen) < size:
            other = self._random.choice(self._movable)
            if other not in chosen:
                chosen.append(other)
        return chosen


_KINDS = (LargeNeighbourhoodSearch._around_delayed, LargeNeighbourhoodSearch._around_place,
          LargeNeighbourhoodSearch._any)
