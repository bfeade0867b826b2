"""Models of a small yard with a door, or a charger, which robots must claim: see `yard_model`.

`Claims` and `Interlocking` are the real ones. The door is a small machine.

Events, in addition to the events of the yard
    * A robot asks for any edge, and claims the door if it lacks only this claim. Or it asks for no
      edge.
    * Claims are stored, together with all other changes, and a request to the door is sent.
    * Any request that was sent arrives: at any time, any number of times, or never.
    * The door opens while its request names a robot, and closes while it names none.
    * A report of the door arrives at once, or never. One report may be kept on its way and come
      late.
    * The door is silent, so that its last report is not fresh any more. Or the door restarts, and
      forgets which request it has obeyed.
    * A grant is stored, but so slowly that the last report of the door is not fresh any more when
      the order is sent.
    * The route of a robot is shortened so that it ends before the door, because no fresh report
      says that the door is open.

Properties, in addition to the properties of the yard
    OPEN      The door is open for each robot on an edge of the door, and for each robot whose route
              leads through the door.
    CLAIMED   Each robot with an edge of the door in its allocation claims the door, in memory and
              in the journal.
    CAPACITY  At most one robot claims the door in the journal.
    ENTERED   A robot is sent into the door only while a fresh report says that the door is open for
              it. This also holds for an order that is sent for the first time after a restart.

In the yard with a charger, which has no device and two places, ALONE takes the place of OPEN: at
most one robot is in the charger, or has a route that leads there.
"""
from __future__ import annotations

from enum import Enum
from typing import (
    Any,
    FrozenSet,
    Iterator,
    NamedTuple,
    Optional,
    Sequence,
    Tuple,
)

from yard_model import (
    Answer,
    Bounds,
    Site,
    State,
    Yard,
)

from fleet_core.interlocking.allocation import Allocation, Knowledge
from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.interlocking import Interlocking
from fleet_core.interlocking.resources import Needs, Resource, ResourceKind
from fleet_core.interlocking.route_master import ME
from fleet_core.supervision.robots import ManagedRobot
from route_protocol.devices import DeviceMode, DeviceRequest

DOOR = 'door'
Names = FrozenSet[str]


class Request(NamedTuple):
    """A request to the door."""

    number: int = 0
    robots: Names = frozenset()


class Said(NamedTuple):
    """A report of the door."""

    request: int
    is_open: bool


class Door(NamedTuple):
    """The door, the messages on their way, and what the fleet manager knows of claims.

    stored  -- the robots that claim the door in the journal
    wanted  -- the robots that want the door
    changed -- the robots whose claims are to be stored
    number  -- the last number that was drawn for a request
    written -- the number in the journal
    begun   -- a request was sent to the door since the start
    request -- the newest request
    asked   -- for each robot, the first request that names it
    told    -- the request in the newest report; 0: this report is not fresh, or does not show OPEN
    sent    -- requests on their way
    obeyed  -- the request that the door obeys
    is_open -- the door is open
    kept    -- a report on its way
    """

    stored: Names = frozenset()
    wanted: Names = frozenset()
    changed: Names = frozenset()
    number: int = 0
    written: int = 0
    begun: bool = False
    request: Request = Request()
    asked: Tuple[Tuple[str, int], ...] = ()
    told: int = 0
    sent: FrozenSet[Request] = frozenset()
    obeyed: Request = Request()
    is_open: bool = False
    kept: Optional[Said] = None

    @property
    def says(self) -> Said:
        """The report that the door makes now."""
        return Said(self.obeyed.number, self.is_open)

    def heard(self, said: Said) -> Door:
        """The state after the fleet manager has heard a report."""
        return self._replace(told=said.request if said.is_open else 0)

    def ranked(self) -> Door:
        """The same door with ranks in place of numbers, because the numbers are only compared."""
        used = {0, self.number, self.written, self.request.number, self.told, self.obeyed.number,
                *(number for _, number in self.asked), *(one.number for one in self.sent)}
        if self.kept is not None:
            used.add(self.kept.request)
        rank = {number: k for k, number in enumerate(sorted(used))}

        def of(request: Request) -> Request:
            return request._replace(number=rank[request.number])

        return self._replace(
            number=rank[self.number], written=rank[self.written], told=rank[self.told],
            request=of(self.request), obeyed=of(self.obeyed), sent=frozenset(map(of, self.sent)),
            asked=tuple((name, rank[number]) for name, number in self.asked),
            kept=self.kept and self.kept._replace(request=rank[self.kept.request]))


class DoorFault(Enum):
    """What goes wrong with the door."""

    RESTART = 'the door restarts'
    SLOW = 'the commit takes long'


class DoorYard(Yard):
    """A yard in which two edges lead through a door.

    edges -- ids of the edges
    """

    edges = frozenset({1, 2})
    clock_of_requests = staticmethod(lambda: 0)

    def __init__(self, *of: Any) -> None:
        super().__init__(*of)
        self._needs = Needs([self._resource()], self._geometry)

    def _resource(self) -> Resource:
        return Resource(DOOR, ResourceKind.DOOR, self.edges, has_device=True)

    def begin(self, bounds: Bounds) -> State:
        """Each robot stands on its vertex, and no request to the door was sent yet."""
        number, *ids = super().begin(bounds)
        stored = {name: self._needs.of_vertex(vertex) for name, vertex in self._begins.items()}
        door = self._door(Door(), Claims(self._needs, stored, 0, self.clock_of_requests))
        return (self._site_id(self._sites[number]._replace(door=door)), *ids)

    # -- claims -----------------------------------------------------------------------------------

    def _claims(self, door: Door, ids: Tuple[int, ...]) -> Claims:
        """The real claims, in the state that fits this door and the robots' allocations."""
        claims = Claims(self._needs, {name: frozenset({DOOR}) for name in door.stored},
                        door.number, self.clock_of_requests)
        claims._wanted = {name: frozenset({DOOR}) for name in door.wanted}
        claims._changed, claims._number = set(door.changed), door.number
        claims._is_begun = door.begun
        claims._asked = {(name, DOOR): number for name, number in door.asked}
        if door.begun and self._needs.resources[DOOR].has_device:
            claims._requests[DOOR] = DeviceRequest(
                ME, DOOR, DeviceMode.OPEN if door.request.robots else DeviceMode.CLOSED,
                door.request.number)
        claims.open_for = {DOOR: door.told} if door.told else {}
        for name, id in zip(self.names, ids):
            claims.follow(name, self._allocations[self._allocated(self._sides[id].belief)])
        return claims

    def _door(self, door: Door, claims: Claims) -> Door:
        request = claims.requests.get(DOOR)
        robots = claims.asked_for(DOOR)
        assert request is None or (request.mode is DeviceMode.OPEN) == bool(robots)
        return door._replace(
            stored=frozenset(name for name in claims.robots if claims.stored_of(name)),
            wanted=frozenset(name for name, own in claims._wanted.items() if own),
            changed=frozenset(claims._changed), number=claims._number, begun=claims._is_begun,
            request=Request() if request is None else Request(request.number, robots),
            asked=tuple(sorted((name, number) for (name, _), number in claims._asked.items()))
        ).ranked()

    def _interlocking_of(self, site: Site, robot: ManagedRobot) -> Interlocking:
        interlocking = super()._interlocking_of(site, robot)
        interlocking.claims = self._claims(site.door, ())
        return interlocking

    def _sent(self, site: Site, id: int) -> int:
        sent = super()._sent(site, id)
        if sent == id or not self._needs.resources[DOOR].has_device:
            return sent
        return self._entering(site.door, self._beliefs[self._sides[id].belief].name, id, sent)

    def _with(self, site: Site, door: Door) -> int:
        return self._site_id(site._replace(door=door.ranked()))

    def _committed(self, site: Site, ids: Tuple[int, ...]) -> Tuple[Site, Tuple[int, ...]]:
        """The state after the robots are stored together with their claims, as in `Outbox`."""
        key = ('committed', site.door, *self._allocated_to(ids))
        if key not in self._known:
            claims = self._claims(site.door, ids)
            changed, written = frozenset(map(self.names.index, claims.to_store)), claims.number
            claims.stored()
            self._known[key] = changed, self._door(site.door._replace(written=written), claims)
        changed, door = self._known[key]
        site, ids = super()._committed(site._replace(to_store=site.to_store | changed), ids)
        return site._replace(door=door), ids

    def _allocated_to(self, ids: Sequence[int]) -> Tuple[int, ...]:
        return tuple(self._views[self._view[id]].allocated for id in ids)

    def _entering(self, door: Door, name: str, id: int, sent: int) -> int:
        """Returns a robot after its order was sent. It has a flaw if the order leads into the door
        while the door is not ready.
        """
        if sent == id:
            return sent
        before, after = self._sides[id], self._sides[sent]
        known = {edge for order in before.orders for edge in order.edges}
        new = {edge.label for order in after.orders - before.orders for edge in order.edges
               if edge not in known}
        is_ready = 0 < dict(door.asked).get(name, 0) <= door.told
        if is_ready or self._may_be_inside(id) or not self.edges & set(map(abs, new)):
            return sent
        return self._put(after._replace(
            flaw=f'ENTERED: {name} is sent into the door, which does not report that it is open'))

    # -- events -----------------------------------------------------------------------------------

    def steps(self, state: State) -> Iterator[Tuple[str, State]]:
        """Each event that is possible now, and the state after it."""
        for event, (number, *ids) in super().steps(state):
            key = ('followed', number, *self._allocated_to(ids))
            if key not in self._known:
                site = self._sites[number]
                door = self._followed_by_claims(site.door, tuple(ids))
                self._known[key] = number if door == site.door else self._with(site, door)
            yield event, (self._known[key], *ids)

    def _followed_by_claims(self, door: Door, ids: Tuple[int, ...]) -> Door:
        """The door after the claims were adapted to the allocations of the robots."""
        key = ('claims', door, *self._allocated_to(ids))
        if key not in self._known:
            self._known[key] = self._door(door, self._claims(door, ids))
        return self._known[key]

    def _granted_in_vain(self, what: str, site: Site,
                         ids: Tuple[int, ...]) -> Iterator[Tuple[str, State]]:
        yield from super()._granted_in_vain(what, site, ids)
        if site.faults and not site.trouble and DoorFault.SLOW in self._bounds.of:
            site, ids = self._committed(site._replace(faults=site.faults - 1), ids)
            late = site._replace(door=site.door._replace(told=0))
            yield f'{what}, but {DoorFault.SLOW.value}', (
                self._site_id(late), *(self._sent(late, id) for id in ids))

    def _ends_before_door(self, site: Site, id: int) -> int:
        """Returns a robot after its route was shortened: it ends before a door that does not report
        that it is open.
        """
        side = self._sides[id]
        if not self._beliefs[side.belief].record.ahead:
            return id
        key = 'keep out', side.belief, side.drawn, site.door
        if key not in self._known:
            robot = self._robot(side)
            self._known[key] = (self._belief_id(robot) if self._interlocking_of(
                site, robot).keep_out() else side.belief)
        return id if self._known[key] == side.belief else self._put(
            side._replace(belief=self._known[key], stale=True))

    def _decisions(self, site: Site, number: int, ids: Tuple[int, ...],
                   k: int) -> Iterator[Tuple[str, State]]:
        yield from super()._decisions(site, number, ids, k)
        ended = self._ends_before_door(site, ids[k])
        if ended != ids[k]:
            yield f'{self.names[k]}: its route ends before the door', self._taken(
                site, (*ids[:k], ended, *ids[k + 1:]))
        key = ('nothing', k, site.door, *self._allocated_to(ids))
        if key not in self._known:
            claims = self._claims(site.door, ids)
            claims.want(self.names[k], ())
            self._known[key] = self._door(site.door, claims)
        door = self._known[key]
        if door != site.door:
            yield f'{self.names[k]}: asks for nothing', (self._with(site, door), *ids)

    def _ask(self, interlocking: Interlocking, robot: ManagedRobot, site: Site,
             ids: Tuple[int, ...], edge: int) -> Answer:
        """Returns the answer to a robot that asks for an edge.

        The robot claims the door if it lacks only this claim.
        """
        interlocking.claims = self._claims(site.door, ids)
        answer = super()._ask(interlocking, robot, site, ids, edge)
        return answer._replace(door=self._door(site.door, interlocking.claims))

    def _of_all(self, site: Site, number: int,
                ids: Tuple[int, ...]) -> Iterator[Tuple[str, State]]:
        door: Door = site.door
        yield from super()._of_all(site, number, ids)
        is_stale = any(self._sides[id].stale for id in ids)
        if not site.trouble and not is_stale and (door.changed or not door.begun):
            committed, stored = self._committed(site, ids)
            yield 'claims are stored', (self._site_id(committed), *stored)
        known = all(self._allocations[self._allocated(self._sides[id].belief)].knowledge
                    is not Knowledge.UNKNOWN for id in ids)
        key = 'door', door, known, self._bounds.kept
        if key not in self._known:
            self._known[key] = [(event, after.ranked()) for event, after in self._door_events(
                door, known, self._bounds.kept) if after != door]
        for event, after in self._known[key]:
            yield event, (self._site_id(site._replace(door=after)), *ids)
        if site.faults and DoorFault.RESTART in self._bounds.of:
            anew = door._replace(obeyed=door.obeyed._replace(number=0), sent=frozenset())
            yield DoorFault.RESTART.value, (
                self._with(site._replace(faults=site.faults - 1), anew), *ids)

    @staticmethod
    def _door_events(door: Door, places_are_known: bool,
                     may_be_late: bool) -> Iterator[Tuple[str, Door]]:
        if door.begun and places_are_known and door.request.number > door.obeyed.number:
            yield 'the door is asked', door._replace(sent=door.sent | {door.request})
        for request in sorted(door.sent, key=lambda request: request.number):
            if request.number > door.obeyed.number:
                yield 'a request arrives at the door', door._replace(
                    obeyed=request, sent=frozenset(
                        one for one in door.sent if one.number > request.number))
        if door.is_open != bool(door.obeyed.robots):
            yield 'the door moves', door._replace(is_open=not door.is_open)
        yield 'the door reports', door.heard(door.says)
        if may_be_late:
            yield 'the door reports, which is kept on its way', door._replace(kept=door.says)
        if door.kept is not None:
            yield 'the kept report of the door is heard', door.heard(door.kept)._replace(kept=None)
        yield 'the door is silent', door._replace(told=0)

    def _restarted_all(self, site: Site, ids: Tuple[int, ...]) -> State:
        return super()._restarted_all(
            site._replace(door=self._restarted_claims(site.door).ranked()), ids)

    def _restarted_claims(self, door: Door) -> Door:
        claims = Claims(self._needs, {name: frozenset({DOOR}) for name in door.stored},
                        door.written, self.clock_of_requests)
        return self._door(door._replace(told=0), claims)

    # -- what must hold ---------------------------------------------------------------------------

    def flaw(self, state: State) -> str:
        """The property that a state violates, and how; empty: it violates none."""
        found = super().flaw(state)
        if found:
            return found
        door: Door = self._sites[state[0]].door
        if len(door.stored) > 1:
            return f'CAPACITY: {sorted(door.stored)} claim the door'
        inside = []
        for name, id in zip(self.names, state[1:]):
            key = 'needs', id
            if key not in self._known:
                side = self._sides[id]
                self._known[key] = self._may_be_inside(id), any(
                    self._holds(self._allocations[allocation])
                    for allocation in (self._allocated(side.belief), self._restored(side)))
            may_be_inside, holds = self._known[key]
            if holds and name not in door.stored:
                return f'CLAIMED: {name} holds a place that needs a claim, but has none'
            inside += [name] * may_be_inside
        return self._wrong_inside(inside, door)

    def _may_be_inside(self, id: int) -> bool:
        """Returns whether a robot is on edges of the resource, or has a route that leads there."""
        vehicle = self._sides[id].vehicle
        edges = {edge.label for edge in (*vehicle.route, *vehicle.rolling)}
        if vehicle.edge is not None:
            edges.add(vehicle.edge.label)
        return bool(self.edges & set(map(abs, edges)))

    def _holds(self, allocation: Allocation) -> bool:
        return bool(self.edges & {abs(hold.edge) for hold in allocation.holds})

    def _wrong_inside(self, inside: Sequence[str], door: Door) -> str:
        """How these robots, which may be inside, violate OPEN or ALONE; empty: they do not."""
        for name in inside:
            if not (door.is_open and name in door.obeyed.robots):
                return f'OPEN: {name} may be in the door, which is not open for it'
        return ''


class ChargerYard(DoorYard):
    """A yard with a charger, which has two places but capacity for only one robot.

    places -- vertices of the charger
    edges  -- the edges at these vertices
    """

    edges = frozenset({2, 3})
    places = frozenset({3, 4})

    def _resource(self) -> Resource:
        return Resource(DOOR, ResourceKind.CHARGER, vertices=self.places)

    def _may_be_inside(self, id: int) -> bool:
        vehicle = self._sides[id].vehicle
        return vehicle.place in self.places and vehicle.edge is None or super()._may_be_inside(id)

    def _holds(self, allocation: Allocation) -> bool:
        return allocation.vertex in self.places or super()._holds(allocation)

    def _wrong_inside(self, inside: Sequence[str], door: Door) -> str:
        return f'ALONE: {inside} may all be in the charger' if len(inside) > 1 else ''
