"""How long robots wait for stations, devices and chargers, and why."""
from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Dict, Iterator, Mapping, NamedTuple, Set

from fleet_core.interlocking.resources import Resource


class HoldUp(Enum):
    """Why a robot waits for a resource."""

    TURN = 'its turn in the queue'
    CLAIM = 'other robots that claim it'
    OPENING = 'its opening'
    BEHIND = 'robots in front that wait for it'


class WaitFor(NamedTuple):
    """The name of the resource for which a robot waits, and the reason."""

    resource: str
    why: HoldUp


def held_up(direct: Mapping[str, WaitFor], behind: Mapping[str, str]) -> Dict[str, WaitFor]:
    """Returns the resource for which each robot waits; robots that wait for none are left out.

    direct -- robots that wait for a resource themselves
    behind -- for each robot, the robot for which it waits; robots may wait for each other in a ring
    """
    found = dict(direct)
    for name in behind:
        seen: Set[str] = set()
        last = name
        while last not in direct and last in behind and last not in seen:
            seen.add(last)
            last = behind[last]
        if name not in direct and last in direct:
            found[name] = WaitFor(direct[last].resource, HoldUp.BEHIND)
    return found


@dataclass
class ResourceUse:
    """How one resource was used in a run.

    claimed -- robot seconds for which robots claimed it
    waiting -- robot seconds for which robots waited for it, by reason
    """

    resource: Resource
    claimed: float = 0.0
    waiting: Dict[HoldUp, float] = field(default_factory=lambda: dict.fromkeys(HoldUp, 0.0))


@dataclass(frozen=True)
class Bottleneck:
    """A resource, and how long robots wait for it. The figures cover several runs of one fleet.

    occupied -- share (0..1) of its capacity that robots claim
    waiting  -- robot minutes per hour for which robots wait for it, by reason
    """

    resource: Resource
    occupied: float
    waiting: Mapping[HoldUp, float]

    @property
    def minutes(self) -> float:
        """Robot minutes per hour for which robots wait for it."""
        return sum(self.waiting.values())


def bottlenecks(runs: Mapping[str, ResourceUse], seconds: float) -> Iterator[Bottleneck]:
    """Yields the resources, the longest waiting time first.

    runs    -- the sums over all runs for each resource, by its name
    seconds -- length of all runs together
    """
    found = [Bottleneck(use.resource, use.claimed / (use.resource.capacity * seconds),
                        {why: 60.0 * wait / seconds for why, wait in use.waiting.items()})
             for use in runs.values() if seconds > 0.0]
    return iter(sorted(found, key=lambda one: (-one.minutes, -one.occupied)))


def summed(*runs: Mapping[str, ResourceUse]) -> Dict[str, ResourceUse]:
    """Returns the sums over several runs, by the name of the resource."""
    found: Dict[str, ResourceUse] = {}
    for run in runs:
        for name, use in run.items():
            whole = found.setdefault(name, ResourceUse(use.resource))
            whole.claimed += use.claimed
            for why, wait in use.waiting.items():
                whole.waiting[why] += wait
    return found
