"""The interlocking: each permission to move a managed robot passes through its `grant`.

It works like a railway's signal box, which does not trust the timetable. The plan says which robot
goes first. The interlocking decides whether a robot may have an edge now, from allocations and
gates alone.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from itertools import takewhile
from typing import (
    AbstractSet,
    Callable,
    Collection,
    Dict,
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

from fleet_core.fleet import RobotType
from fleet_core.geometry.areas import Area, are_nearer
from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.allocation import Allocation, Knowledge
from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.conformance import Conformance, Violation
from fleet_core.interlocking.held_places import HeldPlace, HeldPlaces
from fleet_core.interlocking.reports import GraphPosition
from fleet_core.interlocking.resources import NOTHING, WHOLE, Needs, Resource, Rest
from fleet_core.interlocking.route_master import RouteMaster, Sending

_REMEMBERED = 1000  # number of areas whose near places are cached


class Gate(Enum):
    """Why something is not granted. The values are shown to people."""

    FLEET_STOP = 'the fleet is stopped'
    JOURNAL = 'the journal cannot be written'
    PERSON = 'a person must look after it'
    CLOCK = 'its clock differs too much'
    UNKNOWN = 'it has not reported where it is'
    UNKNOWN_ROBOT = 'it is not known where another robot is'
    NOT_READY = 'its last order is not settled yet'
    NOT_CONNECTED = 'its route does not lead there'
    CLOSED_EDGE = 'an edge is closed'
    CLOSED_TO_LOAD = 'an edge is closed to its load'
    AT_WORK = 'it works at a stop'
    BEFORE_ENTRY = 'a step before the entry has not ended'
    TOO_NEAR = 'it is too near to another robot'
    OCCUPIED = 'another robot may be there'
    CLAIM = 'it has no claim to what it needs there, or the claim is not ready'


class Refusal(NamedTuple):
    """Why an edge is not granted.

    edge     -- signed id of the refused edge
    other    -- name of the robot that is in the way; empty: no robot is
    resource -- what the robot waits for; only for CLAIM
    """

    gate: Gate
    edge: int
    other: str = ''
    resource: Optional[Resource] = None


class InterlockedRobot(Protocol):
    """The properties of a robot that the interlocking needs."""

    @property
    def name(self) -> str:
        """The robot's name."""

    @property
    def type(self) -> RobotType:
        """The robot's type, with its measures."""

    @property
    def master(self) -> RouteMaster:
        """The robot's orders and reports, and the allocation that results from them."""

    @property
    def needs_person(self) -> bool:
        """Whether a person must bring the robot back before it may drive again."""


@dataclass(frozen=True)
class Grant:
    """The edges that are granted, and why the next edge is refused (None: all are granted)."""

    edges: Tuple[int, ...]
    refusal: Optional[Refusal] = None


@dataclass(frozen=True)
class Asked:
    """An edge that a robot requests, as the conditions see it.

    edge      -- signed id; 0: the request is about no edge yet
    before    -- the requested edge before this one; 0: this one is the first
    is_inside -- the robot stands on the edge, between its ends
    place     -- the part of the edge that the robot would hold
    """

    robot: InterlockedRobot
    edge: int = 0
    before: int = 0
    is_inside: bool = False
    place: HeldPlace = HeldPlace(-1)

    @property
    def rest(self) -> Rest:
        """The part of the edge that the robot has still to drive."""
        return Rest(self.place.cleared, self.robot.type.reach)


class Interlocking:
    """Grants edges to the robots of one site.

    No two allocations may exclude each other: the curves of the places of two robots must stay at
    least both reaches and the clearance apart. `grant` therefore gives a robot only edges that all
    GATES and all CONDITIONS allow. Evidence may still make allocations exclude each other. Then
    `separate` stops all these robots: it must be called after each event.

    clearance   -- m that stays free between any two robots
    robots      -- all robots that the fleet manager knows, also those that left the fleet file
    conformance -- checks each step against the model; None: the steps are not checked
    news        -- returns the names of the robots that changed since its last call; None: any robot
                   may have changed at any time
    claims      -- the claims of the robots to resources; None: the site has no resources

    The attributes are the facts on which a grant rests.
    """

    def __init__(self, geometry: SiteGeometry, clearance: float,
                 robots: Mapping[str, InterlockedRobot],
                 conformance: Optional[Conformance] = None,
                 news: Optional[Callable[[], Collection[str]]] = None,
                 claims: Optional[Claims] = None) -> None:
        self.claims = Claims(Needs((), geometry)) if claims is None else claims
        """Which robot may be where a door, a zone or a station is."""
        self.is_stopped = False
        """Whether the fleet is stopped."""
        self.trouble = ''
        """Why the journal cannot be written, as a clause; empty: it can be written."""
        self.closed: AbstractSet[int] = frozenset()
        """Ids of the edges onto which no robot may be sent."""
        self.at_work: AbstractSet[str] = frozenset()
        """Names of the robots that must stand because of their steps."""
        self.not_to_enter: Mapping[str, int] = {}
        """By robot, the vertex that this robot must not enter before a step has ended."""
        self._geometry, self._clearance = geometry, clearance
        self._robots = robots
        self._conformance = conformance
        self._news = news or (lambda: robots)
        self._known: Dict[str, Allocation] = {}
        self._holds = HeldPlaces(geometry, clearance)
        self._stored = HeldPlaces(geometry, clearance)  # according to the journal
        self._to_store: Set[str] = set()
        self._with_areas: Set[str] = set()
        self._unknown: Set[str] = set()
        # robots that have changed, and may exclude another one now
        self._to_compare: Set[str] = set()
        # robots that excluded another one in the last comparison
        self._crowded: Set[str] = set()
        self._near: Dict[Tuple[Area, float], Mapping[int, Tuple[float, float]]] = {}
        for name in self.claims.robots - robots.keys():
            self.claims.forget(name)

    # -- grants -----------------------------------------------------------------------------------

    def grant(self, robot: InterlockedRobot, edges: Sequence[int], renew: bool = False) -> Grant:
        """Grants the first of these edges: as many as the robot may have now.

        If a robot only lacks claims for an edge, it claims what the edge needs, and may have the
        edge later. Claims that it wanted for other edges end.

        The granted edges are added to the robot's allocation and ordered at once. The order is sent
        in the same event, after it is stored on the disk. If it cannot be stored, `not_stored`
        withdraws it.

        edges -- signed ids, in driving order; they follow all edges granted before
        renew -- use a new route id, for example for another mission
        """
        self._refresh()
        refusal = first_refusal(GATES, self, Asked(robot))
        granted: List[int] = []
        if not refusal and self.claims:
            needs = any(map(self.claims.needs.of_edge, edges))
            lacking = self._lacking_claims(robot, edges) if needs else []
            self.claims.want(robot.name, [asked.edge for asked in lacking],
                             lacking[0].rest if lacking else WHOLE)
        for asked in () if refusal else self._asked(robot, edges):
            refusal = first_refusal(CONDITIONS, self, asked)
            if refusal is not None:
                break
            granted.append(asked.edge)
            self._to_store.update(self._stored.excluding(robot.name, robot.type, asked.place))
        if granted:
            before = robot.master.allocation
            robot.master.extend(granted, renew)
            if self._conformance is not None:
                self._conformance.granted(robot.name, granted, self.claims, before,
                                          robot.master.allocation)
        return Grant(tuple(granted), refusal)

    def _lacking_claims(self, robot: InterlockedRobot, edges: Sequence[int]) -> List[Asked]:
        """Returns the first of these edges, as far as nothing but missing claims hinders the robot.
        """
        return list(takewhile(lambda asked: first_refusal(WITHOUT_CLAIMS, self, asked) is None,
                              self._asked(robot, edges)))

    def would_grant(self, wanted: Mapping[str, Sequence[int]]) -> Dict[str, Tuple[int, ...]]:
        """Returns for each robot the first of its edges: as many as could be granted now, if the
        robots before it were granted theirs.

        Nothing is granted. A robot's last order need not be settled yet, because its next report
        will settle it.

        wanted -- edges by the names of the robots, as for `grant`
        """
        self._refresh()
        given = HeldPlaces(self._geometry, self._clearance)
        found: Dict[str, Tuple[int, ...]] = {}
        for name, edges in wanted.items():
            robot, free = self._robots[name], []
            is_refused = first_refusal(LASTING_GATES, self, Asked(robot)) is not None
            for asked in () if is_refused else self._asked(robot, edges):
                if first_refusal(CONDITIONS, self, asked) is not None or any(
                        given.excluding(name, robot.type, asked.place)):
                    break
                free.append(asked)
            given.add(name, robot.type, [asked.place for asked in free])
            found[name] = tuple(asked.edge for asked in free)
        return found

    def _asked(self, robot: InterlockedRobot, edges: Sequence[int]) -> Iterator[Asked]:
        record, before = robot.master.record, 0
        start = None if record.ahead else robot.master.record.position
        for edge in edges:
            begun, is_inside = 0.0, False
            if not before and start is not None:
                begun = record.begun(edge, start)
                is_inside = start.vertex is None
            yield Asked(robot, edge, before, is_inside,
                        HeldPlace(self._geometry.edge_place(edge), edge > 0, begun))
            before = edge

    # -- the journal ------------------------------------------------------------------------------

    @property
    def to_store(self) -> AbstractSet[str]:
        """Names of the robots whose stored allocations are still too near to granted edges.

        Their present allocations must be stored together with these grants. Otherwise allocations
        would exclude each other after a restart.
        """
        return self._to_store

    def stored(self, names: Collection[str]) -> None:
        """Notes that the present allocations of these robots are in the journal now."""
        for name in names:
            if name in self._robots:
                allocation = self._robots[name].master.allocation
                self._stored.put(name, allocation)
                if self._conformance is not None:
                    self._conformance.stored(name, allocation)
        self._to_store.difference_update(names)

    def not_stored(self, trouble: str) -> None:
        """Notes that nothing can be stored now, and withdraws the grants that were to be stored.

        Otherwise their orders would be sent when the journal can be written again, although a door
        may have closed by then. So these edges must pass all gates and conditions again.

        trouble -- why nothing can be stored, as a clause
        """
        self.trouble = trouble
        for robot in self._robots.values():
            robot.master.not_stored()

    # -- conformance ------------------------------------------------------------------------------

    def violations(self) -> List[Violation]:
        """Returns how the event that ends now has violated the model.

        It must be called after the orders of this event have been sent.
        """
        if self._conformance is None:
            return []
        self._refresh()
        return self._conformance.event(self._robots, self._known, self.excluding, self.claims)

    # -- orders that are sent ---------------------------------------------------------------------

    def keep_out(self) -> List[str]:
        """Ends routes in front of devices that do not report at present that they are open.

        Returns the names of the robots whose orders have changed. A robot that is where the device
        is needed may leave, and keeps its route.
        """
        if not self.claims.needs.has_devices:
            return []
        self._refresh()
        found: List[str] = []
        for name, robot in self._robots.items():
            master = robot.master
            if not master.protocol.ahead or master.takes_away or robot.needs_person:
                continue
            first = self._kept_out(robot, min(master.protocol.shown, 1), may_leave=True)
            if first is not None and master.end_after(first):
                found.append(name)
        return found

    def _kept_out(self, robot: InterlockedRobot, begin: int, may_leave: bool) -> Optional[int]:
        """Returns the number of the first edge ahead that the robot may not enter; None: no edge.

        begin     -- number of the first edge that is checked
        may_leave -- the robot may drive on through the resources that its present edge needs
        """
        protocol, needs = robot.master.protocol, self.claims.needs
        here = needs.of_edge(protocol.ahead[0]) if protocol.shown and may_leave else NOTHING
        record = robot.master.record
        start = record.position
        for number, edge in enumerate(protocol.ahead[begin:], begin):
            is_inside = not number and not protocol.shown and (
                start is not None and start.vertex is None)
            rest = Rest(record.begun(edge, start), robot.type.reach) if is_inside else WHOLE
            resource = self.claims.keeping_out(robot.name, edge, is_inside, here, rest)
            if resource:
                return number
        return None

    def orders(self, now: float) -> List[Tuple[str, Sending]]:
        """Returns all orders that are due now. No gate holds back an order that stops a robot or
        shortens its route.

        All other orders are checked against the present reports of devices: since the grant, the
        commit may have taken long, or this program may have restarted.
        """
        found: List[Tuple[str, Sending]] = []
        for name, robot in self._robots.items():
            master = robot.master
            if master.order is None or (not master.takes_away and self._is_held_back(robot)):
                continue
            sending = master.due(now)
            if sending is not None:
                found.append((name, sending))
        return found

    def _is_held_back(self, robot: InterlockedRobot) -> bool:
        """Returns whether an order that lets a robot drive must wait.

        A repeated order does not wait for the journal, because it is stored already.
        """
        if self.is_stopped or robot.needs_person or (
                bool(self.trouble) and robot.master.is_new_motion):
            return True
        if not self.claims.needs.has_devices:
            return False
        self._refresh()
        # The robot may have left a device since its report. This order could lead it back.
        return self._kept_out(robot, robot.master.protocol.shown, may_leave=False) is not None

    def forget(self, name: str) -> None:
        """Removes a robot that is not a robot of the site any more."""
        self._known.pop(name, None)
        self.claims.forget(name)
        self._holds.remove(name)
        self._stored.remove(name)
        self._with_areas.discard(name)
        self._unknown.discard(name)
        self._to_compare.discard(name)
        self._crowded.discard(name)

    # -- robots that exclude each other ------------------------------------------------------------

    @property
    def unknown_robots(self) -> List[str]:
        """Names of the robots that may be anywhere. While there is one, nothing is granted."""
        self._refresh()
        return sorted(self._unknown)

    def excluding(self, name: str) -> Tuple[str, ...]:
        """Returns the names of all robots whose allocations exclude the allocation of this one."""
        self._refresh()
        own = self._known[name]
        if own.knowledge is not Knowledge.KNOWN:
            return ()
        return tuple(sorted(set(self._near_to(name, own, own.kind))))

    def is_free(self, robot: InterlockedRobot, position: GraphPosition) -> bool:
        """Returns whether no other allocation would exclude `robot` at this position."""
        self._refresh()
        if position.vertex is not None:
            return not self.holder(robot, HeldPlace(self._geometry.index[position.vertex]))
        area = Area((position.point(robot.master.record.graph),))
        return next(self._in_area(robot.name, robot.type, area), None) is None

    def without_room(self, robot: InterlockedRobot, kind: RobotType) -> str:
        """Returns the name of a robot that would be too near if this robot became another type.

        Empty: there is none. In that case, robots whose stored allocations are too near must be
        stored, as after a grant.
        """
        self._refresh()
        own = self._known[robot.name]
        if own.knowledge is not Knowledge.KNOWN:
            return robot.name
        other = self._unknown or set(self._near_to(robot.name, own, kind))
        if other:
            return min(other)
        for held in self._holds.places(robot.name):
            self._to_store.update(self._stored.excluding(robot.name, kind, held))
        return ''

    def _near_to(self, name: str, own: Allocation, kind: RobotType) -> Iterator[str]:
        """Yields robots whose allocations would exclude `own` if its robot had the type `kind`."""
        for held in self._holds.places(name):
            yield from self._holders(name, kind, held)
        for area in own.areas:
            yield from self._in_area(name, kind, area)

    def separate(self, is_starting: bool = False) -> List[str]:
        """Stops robots that exclude each other after an allocation changed. Returns their names.

        Nearly every report only removes places from an allocation. Then the robot excludes no
        further robot. So it is compared again only if it excluded another one before.

        Grants never bring two robots too near to each other. Evidence can do so, and a robot that
        drives its route again can, too. In the second case a robot with nothing to drive is not
        stopped, because it is granted nothing meanwhile. A robot that needs a person is stopped
        already.

        is_starting -- robots that have not reported yet are left out: their places are known only
                       roughly
        """
        self._refresh()
        changed, self._to_compare = self._to_compare, set()
        stopped: Dict[str, InterlockedRobot] = {}
        for name in sorted(changed & self._robots.keys()):
            others = self.excluding(name)
            self._crowded.discard(name)
            if others:
                self._crowded.update((name, *others))
            for other in others:
                pair = self._robots[name], self._robots[other]
                if is_starting and not all(robot.master.is_heard for robot in pair):
                    continue
                by_evidence = any(robot.master.is_by_evidence for robot in pair)
                stopped.update((robot.name, robot) for robot in pair if not robot.needs_person
                               and (by_evidence or robot.master.record.ahead))
        for robot in stopped.values():
            robot.master.halt()
        return list(stopped)

    def _in_area(self, name: str, kind: RobotType, area: Area) -> Iterator[str]:
        for other, allocation in self._known.items():
            if other == name or allocation.knowledge is Knowledge.ABSENT:
                continue
            distance = kind.reach + allocation.kind.reach + self._clearance
            near = self._places_near(area, distance)
            places = self._holds.places(other)
            if any(_meets(near.get(held.place), held) for held in places) or any(
                    are_nearer(area.line, its.line, distance + area.radius + its.radius)
                    for its in allocation.areas):
                yield other

    def holder(self, robot: InterlockedRobot, held: HeldPlace) -> str:
        """Returns the name of a robot that holds a place which excludes this place of `robot`.

        Empty: none.
        """
        return next(self._holders(robot.name, robot.type, held), '')

    def _holders(self, own: str, kind: RobotType, held: HeldPlace) -> Iterator[str]:
        """Yields the names of all robots that `holder` may return. A name may come twice."""
        yield from self._holds.excluding(own, kind, held)
        for name in self._with_areas:
            if name == own:
                continue
            allocation = self._known[name]
            distance = kind.reach + allocation.kind.reach + self._clearance
            if any(_meets(self._places_near(area, distance).get(held.place), held)
                   for area in allocation.areas):
                yield name

    def _places_near(self, area: Area, distance: float) -> Mapping[int, Tuple[float, float]]:
        key = area, distance
        if key not in self._near:
            if len(self._near) > _REMEMBERED:
                self._near.clear()
            self._near[key] = self._geometry.exclusions.near(area.line, distance + area.radius)
        return self._near[key]

    def _refresh(self) -> None:
        """Reads each allocation that has changed since the last call."""
        for name in self._news():
            if name not in self._robots:
                continue
            allocation = self._robots[name].master.allocation
            before = self._known.get(name)
            if allocation is before:
                continue
            self._known[name] = allocation
            # A robot that may be anywhere is not compared with others. Others are compared with it.
            if self._unknown or name in self._crowded or before is None or (
                    not allocation.is_within(before)):
                self._to_compare.add(name)
            self._holds.put(name, allocation)
            self.claims.follow(name, allocation)
            for names, is_one in ((self._with_areas, bool(allocation.areas)),
                                  (self._unknown, allocation.knowledge is Knowledge.UNKNOWN)):
                (names.add if is_one else names.discard)(name)


def _meets(part: Optional[Tuple[float, float]], held: HeldPlace) -> bool:
    """Returns whether the blocked part of a place overlaps the part that the robot still holds.

    part -- the blocked part, from one fraction to another; None: nothing is blocked
    """
    if part is None:
        return False
    end = part[1] if held.forward else 1.0 - part[0]
    return not held.cleared or end > held.cleared


# -- conditions of a grant ------------------------------------------------------------------------

Condition = Callable[[Interlocking, Asked], Optional[Refusal]]
"""Returns why an edge is not granted; None: this condition is met."""


def first_refusal(conditions: Sequence[Condition], site: Interlocking,
                  asked: Asked) -> Optional[Refusal]:
    """Returns the refusal of the first condition that is not met; None: all are met."""
    for condition in conditions:
        refusal = condition(site, asked)
        if refusal is not None:
            return refusal
    return None


def _fleet_is_not_stopped(site: Interlocking, asked: Asked) -> Optional[Refusal]:
    return Refusal(Gate.FLEET_STOP, asked.edge) if site.is_stopped else None


def _journal_can_be_written(site: Interlocking, asked: Asked) -> Optional[Refusal]:
    return Refusal(Gate.JOURNAL, asked.edge) if site.trouble else None


def _no_person_is_needed(_: Interlocking, asked: Asked) -> Optional[Refusal]:
    return Refusal(Gate.PERSON, asked.edge) if asked.robot.needs_person else None


def _does_not_work(site: Interlocking, asked: Asked) -> Optional[Refusal]:
    return Refusal(Gate.AT_WORK, asked.edge) if asked.robot.name in site.at_work else None


def _clock_is_right(_: Interlocking, asked: Asked) -> Optional[Refusal]:
    return Refusal(Gate.CLOCK, asked.edge) if asked.robot.master.clock_is_off else None


def _robot_is_known(_: Interlocking, asked: Asked) -> Optional[Refusal]:
    master = asked.robot.master
    known = master.is_heard and master.allocation.knowledge is Knowledge.KNOWN
    return None if known else Refusal(Gate.UNKNOWN, asked.edge)


def _others_are_known(site: Interlocking, asked: Asked) -> Optional[Refusal]:
    others = site.unknown_robots
    return Refusal(Gate.UNKNOWN_ROBOT, asked.edge, others[0]) if others else None


def _last_order_is_settled(_: Interlocking, asked: Asked) -> Optional[Refusal]:
    return None if asked.robot.master.is_ready else Refusal(Gate.NOT_READY, asked.edge)


def _edge_follows(_: Interlocking, asked: Asked) -> Optional[Refusal]:
    """Refuses an edge that does not continue the edge before it, the robot's route, or the place
    where the robot stands.
    """
    record = asked.robot.master.record
    graph, start = record.graph, asked.robot.master.record.position
    if asked.before:
        follows = graph.end_vertex(asked.before).id == graph.start_vertex(asked.edge).id
    elif asked.is_inside and start is not None:
        follows = abs(asked.edge) == abs(start.edge)
    elif record.ahead or start is None:
        follows = graph.start_vertex(asked.edge).id == record.last_vertex
    else:
        follows = graph.start_vertex(asked.edge).id == start.vertex
    return None if follows else Refusal(Gate.NOT_CONNECTED, asked.edge)


def _edge_is_open(site: Interlocking, asked: Asked) -> Optional[Refusal]:
    """Refuses a closed edge, unless the robot is on this edge and leaves it in either direction."""
    closed = abs(asked.edge) in site.closed and not asked.is_inside
    return Refusal(Gate.CLOSED_EDGE, asked.edge) if closed else None


def _edge_is_open_to_load(_: Interlocking, asked: Asked) -> Optional[Refusal]:
    closed = abs(asked.edge) in asked.robot.type.closed and not asked.is_inside
    return Refusal(Gate.CLOSED_TO_LOAD, asked.edge) if closed else None


def _stop_may_be_entered(site: Interlocking, asked: Asked) -> Optional[Refusal]:
    place = site.not_to_enter.get(asked.robot.name)
    ends = place is not None and (
        asked.robot.master.record.graph.end_vertex(asked.edge).id == place)
    return Refusal(Gate.BEFORE_ENTRY, asked.edge) if ends else None


def _robot_is_clear_of_others(site: Interlocking, asked: Asked) -> Optional[Refusal]:
    others = site.excluding(asked.robot.name)
    return Refusal(Gate.TOO_NEAR, asked.edge, others[0]) if others else None


def _place_is_free(site: Interlocking, asked: Asked) -> Optional[Refusal]:
    other = site.holder(asked.robot, asked.place)
    return Refusal(Gate.OCCUPIED, asked.edge, other) if other else None


def _claims_are_ready(site: Interlocking, asked: Asked) -> Optional[Refusal]:
    name = asked.robot.name
    resource = site.claims.keeping_out(name, asked.edge, asked.is_inside, NOTHING,
                                       asked.rest) if site.claims else ''
    if not resource:
        return None
    others = (other for other in site.claims.holders(resource) if other != name)
    return Refusal(Gate.CLAIM, asked.edge, next(others, ''), site.claims.needs.resources[resource])


GATES: Tuple[Condition, ...] = (
    _fleet_is_not_stopped, _journal_can_be_written, _no_person_is_needed, _does_not_work,
    _clock_is_right, _robot_is_known, _others_are_known, _last_order_is_settled,
    _robot_is_clear_of_others)
"""A robot must meet all of these before it is granted anything, even an edge that it holds."""

LASTING_GATES: Tuple[Condition, ...] = tuple(
    gate for gate in GATES if gate is not _last_order_is_settled)
"""The gates that the robot's next report does not open."""

WITHOUT_CLAIMS: Tuple[Condition, ...] = (
    _edge_follows, _edge_is_open, _edge_is_open_to_load, _stop_may_be_entered, _place_is_free)
"""A robot must meet these conditions for an edge before it may claim what the edge needs."""

CONDITIONS: Tuple[Condition, ...] = (*WITHOUT_CLAIMS, _claims_are_ready)
"""A robot must meet these conditions for each granted edge, in addition to GATES."""
