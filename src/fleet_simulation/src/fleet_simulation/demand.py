"""What a site wants its fleet to do: flows of missions, drawn from a seed before anything runs."""
from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import Iterator, List, Tuple, Union

from graph_fleet_manager.supervision.missions import Request

HOUR = 3600.0


@dataclass(frozen=True)
class Shift:
    """From `begin` to `end` (hours) so many missions an hour."""

    begin: float
    end: float
    per_hour: float


@dataclass(frozen=True)
class Saturated:
    """As many as the fleet can serve: `open` missions for each robot are there all the time."""

    open: float = 1.0


@dataclass(frozen=True)
class Flow:
    """Missions of one kind.

    sources      -- vertices that are visited first; empty: none is
    targets      -- vertices that are visited then, one of them drawn evenly
    arrivals     -- shifts, in each of which missions come by chance (Poisson), or saturation
    stay         -- s at each destination, mean; each is drawn within `scatter` (0..1) of it
    """

    name: str
    sources: Tuple[int, ...]
    targets: Tuple[int, ...]
    arrivals: Union[Tuple[Shift, ...], Saturated]
    priority: int = 0
    stay: float = 0.0
    scatter: float = 0.0

    def draw(self, random: Random, id: int, stamp: float) -> Request:
        """One mission."""
        first = (random.choice(self.sources),) if self.sources else ()
        targets = [vertex for vertex in self.targets if vertex not in first]
        destinations = (*first, random.choice(targets))
        stays = tuple(self.stay * random.uniform(1.0 - self.scatter, 1.0 + self.scatter)
                      for _ in destinations) if self.stay else ()
        return Request(id, destinations, priority=self.priority, dwells=stays, stamp=stamp)


@dataclass(frozen=True)
class Recorded:
    """One mission of a real day: s from the beginning, and what it was."""

    at: float
    destinations: Tuple[int, ...]
    priority: int = 0
    stay: float = 0.0


@dataclass(frozen=True)
class Demand:
    """All flows, and missions that were recorded."""

    flows: Tuple[Flow, ...] = ()
    recorded: Tuple[Recorded, ...] = ()

    @property
    def saturated(self) -> Tuple[Flow, ...]:
        """The flows that ask for as much as can be served."""
        return tuple(flow for flow in self.flows if isinstance(flow.arrivals, Saturated))

    def places(self) -> Iterator[int]:
        """The vertices that are visited; some come more than once."""
        for flow in self.flows:
            yield from (*flow.sources, *flow.targets)
        for mission in self.recorded:
            yield from mission.destinations

    def pairs(self) -> Iterator[Tuple[int, int]]:
        """Which vertices are visited one after the other, as far as the demand says so."""
        for flow in self.flows:
            yield from ((source, target) for source in flow.sources for target in flow.targets
                        if source != target)
        for mission in self.recorded:
            yield from zip(mission.destinations, mission.destinations[1:])

    def draw(self, seed: int, hours: float) -> List[Request]:
        """The missions that come at times of their own, in order; ids from 1 on."""
        random = Random(f'demand {seed}')
        drawn: List[Tuple[float, int, Union[Flow, Recorded]]] = []
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
        return [what.draw(random, id, at) if isinstance(what, Flow) else
                Request(id, what.destinations, priority=what.priority, stamp=at,
                        dwells=(what.stay,) * len(what.destinations) if what.stay else ())
                for id, (at, _, what) in enumerate(sorted(drawn, key=lambda d: d[:2]), 1)]
