"""Claims: which robot may be where a resource is needed.

A robot claims a resource before it is granted a place that needs it. The claim is written to the
disk before the device is asked, and before the place is granted. The claim has no time limit: it
ends only when no place of the robot needs the resource any more. So no door closes on a robot that
stands in it, not even after a restart.

A robot claims what its allocation needs, what it wants, and what it claims according to the
journal. The state of a claim is not stored. It follows from three facts:

    | facts                               | state     |
    |-------------------------------------|-----------|
    | not needed,     wanted, not ready   | ASKED     |
    | not needed,     wanted,     ready   | READY     |
    |     needed,                 ready   | IN_USE    |
    |     needed,             not ready   | LOST      |
    | not needed, not wanted              | RETURNING |

    needed -- a place in the robot's allocation needs the resource
    wanted -- the edges that the robot asked for last need the resource
    ready  -- the claim is on the disk; and the device, if there is one, has freshly reported that
              it is open, because of a request that was made with this claim

Events, and the state after them:

    | event                           | ASKED     | READY     | IN_USE    | LOST      | RETURNING |
    |---------------------------------|-----------|-----------|-----------|-----------|-----------|
    | it is ready                     | READY     | READY     | IN_USE    | IN_USE    | RETURNING |
    | it is not ready, or silent      | ASKED     | ASKED     | LOST      | LOST      | RETURNING |
    | a place with it is allocated    | LOST      | IN_USE    | IN_USE    | LOST      | by device |
    | no allocated place needs it     | ASKED     | READY     | by wish   | by wish   | RETURNING |
    | the robot asks for it           | ASKED     | READY     | IN_USE    | LOST      | by device |
    | the robot asks for other edges  | RETURNING | RETURNING | IN_USE    | LOST      | RETURNING |
    | the journal is written          | ASKED     | READY     | IN_USE    | LOST      | it ends   |
    | the fleet manager restarts      | RETURNING | RETURNING | by device | by device | RETURNING |

    by device -- depends on whether it is ready: after a restart a device must report to a new
                 request
    by wish   -- depends on whether the robot wants it

Invariants (`test_claim_proof.py` proves them for any number of robots, places and resources):

(a) an allocated or stored place has all claims that it needs
(b) claims exceed the capacity only because of evidence: a robot at a place has its claims anyway
(c) a claim is stored before the device is asked, and ends only when no place needs it any more
(d) an edge into a resource is granted only with a claim that is READY or IN_USE, and the order for
    it is sent only with such a claim
"""
from __future__ import annotations

from enum import Enum
from typing import (
    AbstractSet,
    Callable,
    Dict,
    FrozenSet,
    Iterable,
    Iterator,
    List,
    Mapping,
    NamedTuple,
    Optional,
    Sequence,
    Set,
    Tuple,
)

from fleet_core.interlocking.allocation import Allocation, Knowledge
from fleet_core.interlocking.resources import NOTHING, WHOLE, Needs, Rest
from fleet_core.interlocking.route_master import ME
from route_protocol.devices import DeviceMode, DeviceRequest


class ClaimState(Enum):
    """The state of a claim. The values are shown to people."""

    ASKED = 'asked'
    READY = 'ready'
    IN_USE = 'in use'
    LOST = 'lost'            # the robot may be there, and the device does not say that it is open
    RETURNING = 'returning'  # it ends with the next commit


class Facts(NamedTuple):
    """The facts from which the state of a claim follows."""

    needed: bool
    wanted: bool
    ready: bool

    @property
    def state(self) -> ClaimState:
        """The state of the claim."""
        if self.needed:
            return ClaimState.IN_USE if self.ready else ClaimState.LOST
        if self.wanted:
            return ClaimState.READY if self.ready else ClaimState.ASKED
        return ClaimState.RETURNING


ClaimsOf = Mapping[str, FrozenSet[str]]
"""Names of resources, by the names of the robots that claim them."""


class Claims:
    """The claims of all robots of a site.

    stored -- the claims in the journal
    number -- the highest number of a request in the journal
    clock  -- returns ms since 1970, so that no number is used twice even with an older journal

    The class has one method for each event of a claim, and one for each question about claims.
    """

    def __init__(self, needs: Needs, stored: Optional[ClaimsOf] = None, number: int = 0,
                 clock: Callable[[], int] = lambda: 0) -> None:
        self.needs = needs
        self.open_for: Mapping[str, int] = {}
        """The resources whose devices freshly report that they are open. The value is the number of
        the request that the device obeys.
        """
        self._clock = clock
        self._number = number
        # The three reasons for claims, by robot. Resources that left the site are omitted.
        self._stored = {name: own & needs.resources.keys() for name, own in (stored or {}).items()}
        self._wanted: Dict[str, FrozenSet[str]] = {}
        # Until its allocation is known, a robot may need all that it claims in the journal.
        self._needed: Dict[str, FrozenSet[str]] = dict(self._stored)
        self._changed: Set[str] = set()  # robots whose claims differ from those in the journal
        self._asked: Dict[Tuple[str, str], int] = {}  # number of the first request for this robot
        self._requests: Dict[str, DeviceRequest] = {}
        self._is_begun = not needs.has_devices
        if not self._is_begun:
            self._draw()

    # -- state ------------------------------------------------------------------------------------

    def __bool__(self) -> bool:
        """Returns whether the site has any resource."""
        return bool(self.needs.resources)

    def of(self, name: str) -> FrozenSet[str]:
        """Returns the names of the resources that a robot claims."""
        return self._kept(name) | self.stored_of(name)

    def stored_of(self, name: str) -> FrozenSet[str]:
        """Returns the names of the resources that a robot claims according to the journal."""
        return self._stored.get(name, NOTHING)

    @property
    def robots(self) -> AbstractSet[str]:
        """Names of the robots that have, or had, claims."""
        return self._stored.keys() | self._needed.keys() | self._wanted.keys()

    def holders(self, resource: str) -> List[str]:
        """Returns the names of the robots that claim a resource."""
        return sorted(name for name in self.robots if resource in self.of(name))

    def state(self, name: str, resource: str) -> Optional[ClaimState]:
        """Returns the state of a robot's claim to a resource; None: it has none."""
        if resource not in self.of(name):
            return None
        return Facts(resource in self._needed.get(name, NOTHING),
                     resource in self._wanted.get(name, NOTHING),
                     self._is_ready(name, resource)).state

    def lost(self) -> Iterator[Tuple[str, str]]:
        """Yields the claims that are LOST, as pairs of robot and resource."""
        for name in sorted(self.robots):
            for resource in sorted(self.of(name)):
                has_device = self.needs.resources[resource].has_device
                if has_device and self.state(name, resource) is ClaimState.LOST:
                    yield name, resource

    def _is_ready(self, name: str, resource: str) -> bool:
        if resource not in self.stored_of(name):
            return False
        if not self.needs.resources[resource].has_device:
            return True
        asked = self._asked.get((name, resource))
        return asked is not None and self.open_for.get(resource, 0) >= asked

    def keeping_out(self, name: str, edge: int, is_inside: bool,
                    here: AbstractSet[str] = NOTHING, rest: Rest = WHOLE) -> str:
        """Returns the name of a resource that keeps a robot from driving a signed edge now.

        Empty: none does.

        A robot that is already where a resource is needed may leave, even if the device is shut.

        is_inside -- the robot stands on the edge, between its ends
        here      -- resources that the robot's present edge needs; the robot is in them already
        rest      -- the part of the edge that the robot has still to drive
        """
        needed = self.needs.of_edge(edge, rest)
        if not needed:
            return ''
        entered = self.needs.on_entry(edge, is_inside) - here
        for resource in sorted(needed):
            if resource not in self.stored_of(name) or resource in entered and (
                    self.state(name, resource) not in (ClaimState.READY, ClaimState.IN_USE)):
                return resource
        return ''

    # -- changes ----------------------------------------------------------------------------------

    def follow(self, name: str, allocation: Allocation) -> None:
        """Notes that a robot has this allocation now.

        The robot claims what these places need, even if that exceeds the capacity.
        """
        if not self:
            return
        needed = (self.of(name) if allocation.knowledge is Knowledge.UNKNOWN
                  else self.needs.of(allocation, self.of(name)))
        if needed != self._needed.get(name):
            self._needed[name] = needed
            self._note(name)

    def want(self, name: str, edges: Sequence[int], rest: Rest = WHOLE) -> None:
        """Notes that a robot asks for these signed edges and for no others. It claims what they
        need.

        A run is a row of consecutive edges that all need something. The robot gets the claims for a
        run together or not at all. The runs are taken in driving order, up to the first one without
        claims.

        rest -- the part of the first edge that the robot has still to drive
        """
        if not self or not edges and not self._wanted.get(name):
            return
        wanted = NOTHING
        for needed in self._stretches(edges, rest):
            if not all(self._is_free(name, resource) for resource in needed):
                break
            wanted |= needed
        self._wanted[name] = wanted
        self._note(name)

    def _stretches(self, edges: Iterable[int], rest: Rest) -> Iterator[FrozenSet[str]]:
        """Yields what each run of edges needs. In a run, every edge needs something."""
        run = NOTHING
        for number, edge in enumerate(edges):
            needed = self.needs.of_edge(edge, WHOLE if number else rest)
            if run and not needed:
                yield run
            run = run | needed if needed else NOTHING
        if run:
            yield run

    def _is_free(self, name: str, resource: str) -> bool:
        """Returns whether a robot claims a resource, or may claim it."""
        holders = self.holders(resource)
        return name in holders or len(holders) < self.needs.resources[resource].capacity

    def forget(self, name: str) -> None:
        """Notes that a robot is not on the site any more."""
        self._needed[name] = self._wanted[name] = NOTHING
        self._note(name)

    def _note(self, name: str) -> None:
        """Notes whether a robot's claims differ from those in the journal."""
        if self._kept(name) == self.stored_of(name):
            self._changed.discard(name)
        elif name not in self._changed:
            self._changed.add(name)
            self._draw()

    def _kept(self, name: str) -> FrozenSet[str]:
        """Returns the claims of a robot that do not end with the next commit."""
        return self._needed.get(name, NOTHING) | self._wanted.get(name, NOTHING)

    def _draw(self) -> None:
        self._number = max(self._number + 1, self._clock())

    # -- the journal, and requests to devices -----------------------------------------------------

    @property
    def is_changed(self) -> bool:
        """Whether claims must be stored now."""
        return bool(self._changed) or not self._is_begun

    @property
    def number(self) -> int:
        """The number that the requests after the next commit get. It is stored with the claims."""
        return self._number

    @property
    def to_store(self) -> ClaimsOf:
        """The claims to be stored: all claims of each robot whose claims have changed.

        These robots must be stored together with their claims, so that each stored place has its
        stored claims.
        """
        return {name: self._kept(name) for name in sorted(self._changed)}

    def stored(self) -> None:
        """Notes that the claims of `to_store` are in the journal now. Makes the requests to the
        devices whose claims have changed.
        """
        told = set() if self._is_begun else set(self.needs.resources)
        self._is_begun = True
        for name, kept in self.to_store.items():
            told |= self.stored_of(name) ^ kept
            self._stored[name] = kept
        self._changed.clear()
        for resource in sorted(told):
            if self.needs.resources[resource].has_device:
                self._ask(resource)

    def _ask(self, resource: str) -> None:
        robots = {name for name, own in self._stored.items() if resource in own}
        self._requests[resource] = DeviceRequest(
            ME, resource, DeviceMode.OPEN if robots else DeviceMode.CLOSED, self._number)
        before = self.asked_for(resource)
        for name in before - robots:
            del self._asked[name, resource]
        for name in robots - before:
            self._asked[name, resource] = self._number

    def asked_for(self, resource: str) -> FrozenSet[str]:
        """Returns the names of the robots for which the newest request keeps the device open."""
        return frozenset(name for name, asked in self._asked if asked == resource)

    def outnumber(self, number: int) -> None:
        """Notes that a device obeys a request with this number, which this journal does not have.

        The device obeys no request with a lower number. So each device is asked anew, with a higher
        number, and only the new requests count.
        """
        self._number = max(self._number, number)
        self._asked.clear()
        self._is_begun = False
        self._draw()

    @property
    def requests(self) -> Mapping[str, DeviceRequest]:
        """The newest request to each device, by resource. The claims for it are in the journal."""
        return self._requests
