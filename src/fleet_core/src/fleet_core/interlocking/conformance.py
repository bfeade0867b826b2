"""Conformance: each change of the real allocations is a step of the model of allocations.

The model proves for any number of robots that allocations stay apart, contain what robots may
drive, and are in the journal (`test/interlocking/test_allocation_proof.py`). The proof holds for
this program only if the program does what the model does. So after each event, this module maps the
real state to the relations of the model, and checks the step from the previous state:

    | relation of the model       | real state                                                     |
    |-----------------------------|----------------------------------------------------------------|
    | allocation(robot, place)    | edges in the robot's allocation                                |
    | journal(robot, place)       | edges in the allocation that was stored last                   |
    | sent(robot, place)          | edges of the open orders that may have left this program       |

The model of claims (`test/interlocking/test_claim_proof.py`) has these relations as well:

    | claim(robot, resource)        | the robot's claims                                           |
    | stored_claim(robot, resource) | its claims in the journal                                    |

The models also have relations for what robots really obey and for where they are. No program knows
these two; the simulations check them with their own robots.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import (
    Callable,
    Collection,
    Dict,
    FrozenSet,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Protocol,
    Sequence,
    Set,
    Tuple,
)

from fleet_core.interlocking.allocation import Allocation, Knowledge
from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.resources import NOTHING, Needs, Rest
from fleet_core.interlocking.route_master import RouteMaster
from route_protocol.master import MasterState
from trajectory_graph.id_lists import listed


class Invariant(Enum):
    """What must hold for each step. The values say how it is violated; they are shown to people."""

    CHECKED = 'it holds places that it was not granted'
    CONTAINED = 'it was sent over edges that it does not hold'
    STORED = 'it was sent over edges that the journal does not have'
    READ = 'the interlocking does not know its present allocation'
    APART = 'it is too near to another robot, and is not stopped'
    CLAIMED = 'it may be where it needs something that it does not claim'
    CLAIM_STORED = 'its allocation in the journal needs something that it does not claim'
    GRANTED = 'it was granted edges that need something for which the journal has no claim'
    CAPACITY = 'it claims something that others claim already'
    ASKED = 'a device was asked for it without a claim in the journal'


@dataclass(frozen=True)
class Violation:
    """A step that the model does not allow.

    edges -- signed ids; empty for APART and READ, and for violations about areas or claims
    other -- name of the other robot; only for APART
    resources -- names; only for violations about claims
    """

    invariant: Invariant
    robot: str
    edges: FrozenSet[int] = frozenset()
    other: str = ''
    resources: FrozenSet[str] = frozenset()

    def __str__(self) -> str:
        where = f' (robot {self.other})' * bool(self.other) or (
            f' (edges {listed(sorted(self.edges))})' * bool(self.edges)) or (
            f' ({", ".join(sorted(self.resources))})' * bool(self.resources))
        return f'{self.robot}: {self.invariant.value}{where}'


class ModelState(NamedTuple):
    """The relations of the model for one robot, as sets of signed edge ids."""

    allocation: FrozenSet[int]
    journal: FrozenSet[int]
    sent: FrozenSet[int]


class ObservedRobot(Protocol):
    """The properties of a robot that conformance needs."""

    @property
    def master(self) -> RouteMaster:
        """The robot's orders and reports."""

    @property
    def needs_person(self) -> bool:
        """Whether a person must bring the robot back before it may drive again."""


def edges_of(allocation: Allocation) -> FrozenSet[int]:
    """Returns the signed ids of all edges that an allocation holds."""
    return frozenset(hold.edge for hold in allocation.holds)


class Conformance:
    """Compares the state after events with the state at the last check.

    every -- number of events from one check to the next
    """

    def __init__(self, every: int = 1) -> None:
        self._every, self._events = every, 0
        self._before: Dict[str, ModelState] = {}
        self._seen: Dict[str, Tuple[Allocation, MasterState, int]] = {}
        self._granted: Dict[str, Set[int]] = {}
        self._grown: Set[str] = set()  # robots whose allocation a grant extended by areas, too
        self._journal: Dict[str, FrozenSet[int]] = {}
        self._stored: Dict[str, Allocation] = {}
        self._claims: Dict[str, FrozenSet[str]] = {}
        self._unclaimed: Dict[str, FrozenSet[str]] = {}
        # by robot: the needs of its present or its stored allocation, until the allocation changes
        self._needed: Dict[Tuple[str, bool], Tuple[Allocation, FrozenSet[str]]] = {}

    def granted(self, name: str, edges: Collection[int], claims: Claims,
                before: Allocation, after: Allocation) -> None:
        """Notes that the interlocking has granted these edges to a robot, with these claims."""
        self._granted.setdefault(name, set()).update(edges)
        if not set(after.areas) <= set(before.areas):
            self._grown.add(name)
        if claims:
            needed = NOTHING.union(*(
                claims.needs.of_edge(hold.edge, Rest(hold.cleared, after.kind.reach))
                for hold in after.holds if hold.edge in edges))
            self._unclaimed[name] = self._unclaimed.get(name, NOTHING) | (
                needed - claims.stored_of(name))

    def stored(self, name: str, allocation: Allocation) -> None:
        """Notes that this allocation of a robot is in the journal."""
        self._journal[name] = edges_of(allocation)
        self._stored[name] = allocation

    def event(self, robots: Mapping[str, ObservedRobot], known: Mapping[str, Allocation],
              excluding: Callable[[str], Sequence[str]], claims: Claims) -> List[Violation]:
        """Returns what is wrong after an event; empty: nothing, or no check is due.

        known     -- the allocations that the interlocking has read
        excluding -- returns the names of the robots that exclude a robot
        claims    -- of all robots
        """
        self._events += 1
        if self._events % self._every:
            return []
        found = [Violation(Invariant.CHECKED, name) for name in sorted(self._grown)]
        self._grown.clear()
        for name, robot in robots.items():
            if known.get(name) is not robot.master.allocation:
                found.append(Violation(Invariant.READ, name))
            if not self._is_seen(name, robot.master):
                found += self._wrong_edges(name, robot)
                found += self._too_near(name, robots, excluding)
        self._granted.clear()
        return [*found, *self._wrong_claims(robots, claims)] if claims else found

    def _wrong_edges(self, name: str, robot: ObservedRobot) -> List[Violation]:
        """Returns what is wrong with the edges of a robot that has changed."""
        now, before = self._state(name, robot), self._before.get(name)
        self._before[name] = now
        return [Violation(invariant, name, edges) for invariant, edges in (
            (Invariant.CHECKED, frozenset() if before is None else
             now.allocation - before.allocation - self._granted.get(name, set())),
            (Invariant.CONTAINED, now.sent - now.allocation),
            (Invariant.STORED, now.sent - now.journal)) if edges]

    @staticmethod
    def _too_near(name: str, robots: Mapping[str, ObservedRobot],
                  excluding: Callable[[str], Sequence[str]]) -> List[Violation]:
        """Returns a violation if this robot may drive although another one excludes it.

        Robots that have not reported since the start do not count, because their places are known
        only roughly.
        """
        master = robots[name].master
        if not master.protocol.ahead or master.is_stopping or robots[name].needs_person or (
                not master.is_heard):
            return []
        return [Violation(Invariant.APART, name, other=other)
                for other in excluding(name) if robots[other].master.is_heard][:1]

    def _wrong_claims(self, robots: Mapping[str, ObservedRobot],
                      claims: Claims) -> Iterator[Violation]:
        """Yields what is wrong with claims. Only evidence may make claims exceed a capacity.

        Whether evidence was the cause is known only if there is a check after each event.
        """
        for name, robot in robots.items():
            allocation, stored = robot.master.allocation, self._stored.get(name)
            needed = self._needs_of(name, allocation, claims.needs)
            now, before = claims.of(name), self._claims.get(name)
            self._claims[name] = now
            new = NOTHING if before is None or self._every > 1 else now - needed - before
            over = frozenset(one for one in new if len(claims.holders(one))
                             > claims.needs.resources[one].capacity)
            # A robot whose place is unknown since the start claims again when its place is known.
            unstored = NOTHING if allocation.knowledge is Knowledge.UNKNOWN else (
                self._needs_of(name, stored, claims.needs, True) - claims.stored_of(name))
            for invariant, resources in (
                    (Invariant.CLAIMED, needed - now),
                    (Invariant.CLAIM_STORED, unstored - claims.to_store.get(name, NOTHING)),
                    (Invariant.GRANTED, self._unclaimed.pop(name, NOTHING)),
                    (Invariant.CAPACITY, over),
                    (Invariant.ASKED, frozenset(
                        resource for resource in claims.requests
                        if name in claims.asked_for(resource)) - claims.stored_of(name))):
                if resources:
                    yield Violation(invariant, name, resources=resources)

    def _needs_of(self, name: str, allocation: Optional[Allocation], needs: Needs,
                  is_stored: bool = False) -> FrozenSet[str]:
        """Returns what the places of an allocation need; nothing if the robot may be anywhere."""
        if allocation is None or allocation.knowledge is not Knowledge.KNOWN:
            return NOTHING
        kept = self._needed.get((name, is_stored))
        if kept is None or kept[0] is not allocation:
            kept = self._needed[name, is_stored] = allocation, needs.of(allocation)
        return kept[1]

    def _is_seen(self, name: str, master: RouteMaster) -> bool:
        """Returns whether the state has not changed since the last check.

        Each change makes new objects.
        """
        before = self._seen.get(name)
        now = self._seen[name] = master.allocation, master.protocol, master.last_sent
        return before is not None and before[2] == now[2] and (
            before[0] is now[0] and before[1] is now[1])

    def _state(self, name: str, robot: ObservedRobot) -> ModelState:
        return ModelState(edges_of(robot.master.allocation), self._journal.get(name, frozenset()),
                          frozenset(
                              step.edge for order in robot.master.protocol.open
                              if order.number <= robot.master.last_sent
                              for step in order.steps(robot.master.protocol.done)))
