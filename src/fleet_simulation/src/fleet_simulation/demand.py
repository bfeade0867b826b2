"""The demand of a site: flows of missions, which are drawn from a seed before a run begins."""
from __future__ import annotations

from dataclasses import dataclass
from itertools import chain, product
from random import Random
from typing import Dict, Iterator, List, Sequence, Tuple, Union

from fleet_core.supervision.missions import Request

HOUR = 3600.0
_FIRST_SATURATED = 1_000_000  # id of the first mission of a saturated flow


@dataclass(frozen=True)
class Shift:
    """A period with `per_hour` missions per hour; `begin` and `end` are in hours from the start."""

    begin: float
    end: float
    per_hour: float


@dataclass(frozen=True)
class Saturated:
    """As many missions as the fleet can serve: at any time, `open` missions per robot are open."""

    open: float = 1.0


@dataclass(frozen=True)
class Flow:
    """Missions of one kind. A mission visits at most one source, then one target.

    sources      -- vertices; each mission first visits one of them, drawn evenly; may be empty
    targets      -- vertices; each mission then visits one of them, drawn evenly
    arrivals     -- shifts, during which missions come at random times (Poisson), or `Saturated`
    priority     -- priority of the missions; missions of a higher priority are served first
    stay         -- mean dwell at each destination, in s
    scatter      -- 0..1; each dwell is drawn between (1 - scatter) and (1 + scatter) times `stay`
    deadline     -- s from the request of a mission to its deadline; 0: no deadline
    """

    name: str
    sources: Tuple[int, ...]
    targets: Tuple[int, ...]
    arrivals: Union[Tuple[Shift, ...], Saturated]
    priority: int = 0
    stay: float = 0.0
    scatter: float = 0.0
    deadline: float = 0.0

    @property
    def visits(self) -> Tuple[Tuple[int, ...], ...]:
        """For each destination of a mission, the vertices from which the destination is drawn."""
        return (*((self.sources,) if self.sources else ()), self.targets)

    def draw(self, random: Random, id: int, stamp: float) -> Request:
        """Draws one mission with this id and stamp (virtual s)."""
        first = (random.choice(self.sources),) if self.sources else ()
        targets = [vertex for vertex in self.targets if vertex not in first]
        destinations = (*first, random.choice(targets))
        stays = tuple(self.stay * random.uniform(1.0 - self.scatter, 1.0 + self.scatter)
                      for _ in destinations) if self.stay else ()
        return Request(id, destinations, priority=self.priority, dwells=stays, stamp=stamp,
                       deadline=stamp + self.deadline if self.deadline else 0.0)


@dataclass(frozen=True)
class WorkFlow:
    """Missions that are made from a template of the work file.

    arguments -- values for each parameter of the template; each mission gets one value, drawn
                 evenly
    visits    -- for each stop, the vertices to which it may lead
    arrivals, priority, deadline -- as in `Flow`
    """

    name: str
    template: str
    arguments: Tuple[Tuple[str, Tuple[str, ...]], ...]
    visits: Tuple[Tuple[int, ...], ...]
    arrivals: Union[Tuple[Shift, ...], Saturated]
    priority: int = 0
    deadline: float = 0.0

    def draw(self, random: Random, id: int, stamp: float) -> Request:
        """Draws one mission with this id and stamp (virtual s)."""
        return Request(id, (), priority=self.priority, stamp=stamp, template=self.template,
                       arguments=tuple((name, random.choice(values))
                                       for name, values in self.arguments),
                       deadline=stamp + self.deadline if self.deadline else 0.0)


AnyFlow = Union[Flow, WorkFlow]


@dataclass(frozen=True)
class Recorded:
    """One mission of a recorded day.

    at   -- s from the beginning to the request
    stay -- dwell at each destination, in s
    """

    at: float
    destinations: Tuple[int, ...]
    priority: int = 0
    stay: float = 0.0


@dataclass(frozen=True)
class Demand:
    """All flows and all recorded missions of a site."""

    flows: Tuple[AnyFlow, ...] = ()
    recorded: Tuple[Recorded, ...] = ()

    @property
    def saturated(self) -> Tuple[AnyFlow, ...]:
        """The flows with as many missions as the fleet can serve."""
        return tuple(flow for flow in self.flows if isinstance(flow.arrivals, Saturated))

    def places(self) -> Iterator[int]:
        """Yields the vertices that missions visit; a vertex may come several times."""
        for flow in self.flows:
            yield from chain.from_iterable(flow.visits)
        for mission in self.recorded:
            yield from mission.destinations

    def pairs(self) -> Iterator[Tuple[int, int]]:
        """Yields each pair of vertices that a mission may visit one after the other."""
        for flow in self.flows:
            for before, after in zip(flow.visits, flow.visits[1:]):
                yield from ((one, other) for one, other in product(before, after) if one != other)
        for mission in self.recorded:
            yield from zip(mission.destinations, mission.destinations[1:])

    def draw(self, seed: int, hours: float) -> List[Request]:
        """Returns the missions of shifts and recordings, sorted by time; their ids begin at 1.

        Times and deadlines are in virtual s. Missions of saturated flows are not included, because
        their number depends on the fleet.
        """
        random = Random(f'demand {seed}')
        drawn: List[Tuple[float, int, Union[AnyFlow, Recorded]]] = []
        for flow in self.flows:
            if isinstance(flow.arrivals, Saturated):
                continue
            for shift in flow.arrivals:
                at, end = shift.begin * HOUR, min(shift.end, hours) * HOUR
                while shift.per_hour > 0.0:
                    at += random.expovariate(shift.per_hour / HOUR)
                    if at >= end:
                        break
                    drawn.append((at, len(drawn), flow))
        drawn += [(mission.at, len(drawn) + number, mission)
                  for number, mission in enumerate(self.recorded) if mission.at < hours * HOUR]
        return [Request(id, what.destinations, priority=what.priority, stamp=at,
                        dwells=(what.stay,) * len(what.destinations) if what.stay else ())
                if isinstance(what, Recorded) else what.draw(random, id, at)
                for id, (at, _, what) in enumerate(sorted(drawn, key=lambda d: d[:2]), 1)]


class RequestSource:
    """The requests of one run: the drawn requests, and those of the saturated flows.

    drawn  -- requests, sorted by time
    random -- draws the missions of saturated flows
    """

    def __init__(self, demand: Demand, drawn: Sequence[Request], random: Random) -> None:
        self._demand, self._random = demand, random
        self._ready = list(reversed(drawn))
        self._next_id = _FIRST_SATURATED
        self._saturating: Dict[int, int] = {}
        """For each mission id: the number of the saturated flow that requested the mission."""

    def due(self, now: float, robots: int, step: float) -> Iterator[Request]:
        """Yields the requests that are due now.

        robots -- the size of the fleet
        step   -- virtual s between a request and its arrival at the supervisor
        """
        while self._ready and self._ready[-1].stamp <= now:
            yield self._ready.pop()
        for number, flow in enumerate(self._demand.saturated):
            assert isinstance(flow.arrivals, Saturated)
            wanted = max(1, round(flow.arrivals.open * robots))
            while sum(one == number for one in self._saturating.values()) < wanted:
                self._saturating[self._next_id] = number
                request = flow.draw(self._random, self._next_id, now + step)
                self._next_id += 1
                yield request

    def ended(self, id: int) -> None:
        """Notes that a mission has ended; a saturated flow then requests another one."""
        self._saturating.pop(id, None)
