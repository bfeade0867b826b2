"""A model of numbered orders: one master, one vehicle, and the channels between them.

The channels may lose, delay, repeat and reorder messages, but never invent one. The search visits
every state within its bounds. So the invariants hold for every sequence of events, not only for
those that the author of a test thinks of.

States
    Vehicle -- its epoch; the master that it obeys; the number of the last order that it took from
        this master, and the highest number that it refused; how many edges of its record it has
        driven; its route, or the edges on which it may still roll after it lost its route; its
        place, in half edges
    Master  -- what the newest report said; the number of its last order; the orders that the
        vehicle may still follow (`open`); the edges that stay held until the vehicle stands
    State   -- vehicle, master, the master's journal, and every order and report that was ever sent.
        Only the search uses the fields after these: neither vehicle nor master can read them.

Events
    * Any order or report that was sent arrives: at any time, any number of times, or never.
    * The vehicle drives half an edge, reports, refuses an order for a reason of its own, fails on
      its route, comes to rest, or restarts without its memory. (A restart with its memory changes
      nothing.)
    * Another giver moves the vehicle. Another master, or an old master (without order numbers),
      orders a route or a stop. A person stops the vehicle without the master (a stop with number
      0).
    * The master stores its state, or restarts from its journal, or from an older one. The master
      extends the route to a new place or back to the first place, shortens it, or sends a stop.

Invariants
    A  If an order of this master may still make the vehicle drive an edge, the allocation has it.
    B  The present place or edge of the vehicle is in the allocation. The exception: something
       other than the master has moved the vehicle, and no report shows this yet.
    C  Liveness: if from now on messages arrive and nothing fails, the master brings the vehicle to
       the end of a new edge.
    D  No message of an old master is obeyed twice, or after a newer message was obeyed.
    E  If a report shows an order that the master's journal lacks, the master assumes that the
       vehicle may be anywhere.

A reader who knows RULES and the two functions `obey` and `hear` can predict every case. If the
vehicle has already driven the first edges of an order, no further rule is needed: record numbers
say where the order continues.
"""
from __future__ import annotations

import contextlib
import gc
from collections import deque
from enum import Enum
from typing import (
    Deque,
    Dict,
    FrozenSet,
    Iterable,
    Iterator,
    List,
    NamedTuple,
    Optional,
    Set,
    Tuple,
)

RULES = {
    'number': 'the vehicle ignores an order that is not newer than the last one that it took',
    'refusal': 'the vehicle ignores an order that is not newer than the last one that it refused',
    'epoch': 'the vehicle refuses an order that was decided in another epoch',
    'takeover': 'an order of another master, if it is taken, begins a new epoch',
    'stamp': 'a message of an old master counts only if it is newer than the last and the epoch',
    'sequence': 'the master ignores a report that is older than the newest one',
    'owner': 'the master reads the numbers of a report only if they count its own orders',
    'commit': 'an order is in the journal before it is sent',
    'union': 'all orders that may still arrive are allocated, not only the newest one',
    'standing': 'what a stop, a failure or a new epoch takes away is held until the vehicle stands',
    'moved': 'a vehicle that another giver moves, or that does not know who moves it, may be '
             'anywhere until it stands',
    'older': 'after a start with an older journal the vehicle may be anywhere',
    'gap': 'a reported number that the journal does not know tells that the journal is older',
    'accepted': 'with an older journal only a stop that is drawn afterwards, and after which the '
                'vehicle stood, tells where it is',
    'command': 'the master grants only to a vehicle that counts its orders; it stops others first',
    'clock': 'a number is above all that were ever drawn, also those that the journal has lost',
}

ME, OTHER, OLD, NOBODY = 'me', 'other', 'old', 'nobody'
AWAY = 9  # the place to which another giver moves the vehicle
OTHERS_LABELS, OLD_LABELS, NEW_LABEL = 20, 40, 1000


class Edge(NamedTuple):
    """One edge of a route. Its label is new in each grant."""

    label: int
    origin: int
    destination: int


class Order(NamedTuple):
    """An order of a numbering master; without edges: a stop."""

    number: int
    epoch: int  # the vehicle's epoch in which the order was decided; a stop needs no epoch
    first: int  # record number of edges[0]
    edges: Tuple[Edge, ...]
    master: str = ME


class OldOrder(NamedTuple):
    """The message of a master that does not number its orders. Its stamp grows."""

    stamp: int
    edges: Tuple[Edge, ...]


class Motion(Enum):
    """What the vehicle says about its motion."""

    STANDING = 'standing'
    ON_ROUTE = 'on the route of the order'
    COMING_TO_REST = 'rolls on from a lost route of the master that it names'
    MOVED = 'moves otherwise'
    UNKNOWN = 'moves, and does not know by whose order'

    __hash__ = object.__hash__  # members are compared by identity; Enum.__hash__ is slow


class Report(NamedTuple):
    """What the vehicle reports."""

    sequence: int  # grows, even after restarts
    epoch: int
    master: str  # `order` and `refused` count the orders of this master
    order: int
    refused: int
    done: int  # record number of the first edge that is not driven to its end
    motion: Motion
    failed: bool  # the vehicle has lost the route of `order`
    place: Optional[int]  # where the vehicle stands; None: it is on `edge`
    edge: Optional[Edge]


class Vehicle(NamedTuple):
    """The vehicle. No answer to an order depends on the last two fields."""

    epoch: int = 1
    master: str = ME  # the master whose orders it counts
    order: int = 0  # number of the last order that it took in this epoch
    refused: int = 0  # highest number of an order that it refused in this epoch
    done: int = 0  # edges driven in this epoch
    route: Tuple[Edge, ...] = ()  # the edges from `done` on
    rolling: Tuple[Edge, ...] = ()  # without a route: the edges that it may still drive
    failed: bool = False
    place: Optional[int] = 0
    edge: Optional[Edge] = None  # kept after it lost its route
    sequence: int = 0
    stamp: int = 0  # messages of old masters with this stamp, or an older stamp, are too old
    giver: str = NOBODY  # the program whose order moves it
    moved_since: int = -1  # number of the last report before another giver moved it


class Master(NamedTuple):
    """The master."""

    epoch: int = 1
    sequence: int = 0  # number of the newest report
    number: int = 0  # number of its last order
    done: int = 0
    open: Tuple[Order, ...] = ()  # orders that the vehicle follows, or may follow later
    held: FrozenSet[Edge] = frozenset()  # edges that stay allocated until the vehicle stands
    anywhere: bool = False  # the vehicle may be anywhere, until it stands
    commands: bool = True  # whether the vehicle counts the orders of this master
    place: Optional[int] = 0
    edge: Optional[Edge] = None
    unknown: int = 0  # the vehicle may be anywhere until it stands after this or a later order
    gap: Tuple[int, int] = (0, 0)  # the journal that was read lacks the numbers between these two


class State(NamedTuple):
    """The whole state. Neither side can read the last four fields."""

    vehicle: Vehicle = Vehicle()
    master: Master = Master()
    journal: Master = Master()
    orders: FrozenSet[Order] = frozenset()
    reports: FrozenSet[Report] = frozenset()
    old_orders: Tuple[OldOrder, ...] = ()
    labels: int = 0
    drawn: int = 0  # the highest number ever drawn; a clock would show it
    others: int = 0
    restores: int = 0
    unaware: bool = False  # the master has not noticed yet that its journal is an older one
    flaw: str = ''


class Bounds(NamedTuple):
    """How often each kind of event may happen.

    others -- orders of another numbering master
    old    -- orders of an old master
    """

    orders: int = 2
    epochs: int = 2
    edges: int = 2
    reports: int = 3
    others: int = 0
    old: int = 0
    restores: int = 0  # restarts with an older journal, from before the first order


class Found(NamedTuple):
    """The result of a search: the number of states, the violation that was found, and the shortest
    sequence of events that leads to it.
    """

    states: int
    flaw: str = ''
    way: Tuple[str, ...] = ()

    def __str__(self) -> str:
        return '\n    '.join((f'{self.flaw or "no violation"} ({self.states} states)', *self.way))


class Model:
    """The transitions between states, with all rules or without some of them."""

    def __init__(self, *without: str) -> None:
        unknown = set(without) - set(RULES)
        assert not unknown, f'there is no rule {unknown}'
        self._rules = {name: name not in without for name in RULES}

    # -- the vehicle ------------------------------------------------------------------------------

    def obey(self, vehicle: Vehicle, order: Order, willing: bool = True, now: int = 0) -> Vehicle:
        """Returns the vehicle after an order has arrived.

        willing -- False: the vehicle refuses a route (emergency stop, lost link, cannot brake)
        now     -- the newest stamp that an old master can have given so far
        """
        rules = self._rules
        if order.master == vehicle.master and (
                rules['number'] and order.number <= vehicle.order
                or rules['refusal'] and order.number <= vehicle.refused):
            return vehicle
        takes_over = vehicle.master not in (NOBODY, order.master)
        if not order.edges:
            lost = without_route(vehicle)
            if takes_over and rules['takeover']:
                lost = new_epoch(lost, now)
            return lost._replace(master=order.master, order=order.number, failed=True,
                                 done=lost.done if lost.order else order.first)
        rest = order.edges
        if takes_over or vehicle.order == 0:  # the record has no edge of this master yet
            done = order.first
        else:
            done = vehicle.done
            rest = rest[done - order.first:] if done >= order.first else ()
        fits = _continues(vehicle, rest) if rest else (
            vehicle.edge is None and done == order.first + len(order.edges))
        if (not willing or not fits or vehicle.rolling
                or rules['epoch'] and order.epoch != vehicle.epoch):
            if takes_over:
                return vehicle
            return vehicle._replace(master=order.master,
                                    refused=max(vehicle.refused, order.number))
        if takes_over and rules['takeover']:
            vehicle = new_epoch(vehicle, now)
        return vehicle._replace(
            master=order.master, order=order.number, done=done, route=rest, failed=False,
            giver=order.master if rest else NOBODY,
            moved_since=vehicle.moved_since if order.master == ME else vehicle.sequence)

    def number_old_order(self, vehicle: Vehicle, message: OldOrder) -> Optional[Order]:
        """Returns the message of an old master as a numbered order; None if it is too old.

        The vehicle finds its present edge in the route, and leaves out the edges before that one.
        """
        if self._rules['stamp'] and message.stamp <= vehicle.stamp:
            return None
        is_in_command = vehicle.master == OLD
        number = max(vehicle.order, vehicle.refused) + 1 if is_in_command else 1
        ahead = message.edges
        while ahead and not _continues(vehicle, ahead):
            ahead = ahead[1:]
        first = vehicle.done if is_in_command else 0
        return Order(number, vehicle.epoch, first, ahead or message.edges, OLD)

    # -- the master -------------------------------------------------------------------------------

    def allocation(self, master: Master) -> Set[Edge]:
        """Returns the allocated edges; only valid if the vehicle is not `anywhere`."""
        edges = set(master.held)
        if master.edge is not None:
            edges.add(master.edge)
        for order in master.open if self._rules['union'] else master.open[-1:]:
            edges.update(order.edges[max(0, master.done - order.first):])
        return edges

    def hear(self, master: Master, said: Report, drawn: int) -> Master:
        """Returns the master after a report has arrived. drawn: the highest number so far."""
        rules = self._rules
        if rules['sequence'] and said.sequence <= master.sequence:
            return master
        is_mine = said.master == ME or not rules['owner']
        order, refused = (said.order, said.refused) if is_mine else (0, 0)
        is_new = said.epoch != master.epoch
        still = tuple(o for o in master.open if (
            not o.edges or o.epoch == said.epoch)
            and o.number >= order and not order < o.number <= refused
            and not (o.number == order and said.failed))
        held: FrozenSet[Edge] = frozenset()
        stands = said.motion is Motion.STANDING
        knows_where = stands or bool(order and still) and not (is_new or said.failed)
        anywhere = master.anywhere
        if rules['standing'] and not knows_where:
            kept = {edge for o in still for edge in o.edges}
            gone = {edge for o in master.open if o not in still for edge in o.edges}
            held = master.held | (self.allocation(master) if is_new else gone - kept)
        if rules['moved'] and not stands and (
                not is_mine or said.motion in (Motion.MOVED, Motion.UNKNOWN)):
            anywhere = True
        elif knows_where:
            anywhere = False
        unknown = master.unknown
        if rules['gap'] and is_mine and _in_gap(master, said):
            unknown = unknown or self._next_number(master, drawn)
        elif unknown and stands and (
                not rules['accepted'] or is_mine and order >= unknown):
            unknown = 0
        return master._replace(
            sequence=said.sequence, epoch=said.epoch, open=still, held=held, anywhere=anywhere,
            commands=said.master == ME or not rules['command'], place=said.place,
            edge=said.edge, unknown=unknown,
            done=said.done if order else 0 if is_new else master.done)

    def first_master(self, gap: Tuple[int, int] = (0, 0), unknown: int = 0) -> Master:
        """Returns the master at its start, with the journal from before the first order."""
        return Master(gap=gap, unknown=unknown)

    def give(self, master: Master, order: Order) -> Master:
        """Returns the master after it has given an order."""
        return master._replace(number=order.number, open=(*master.open, order))

    def end(self, master: Master) -> Optional[Tuple[int, Tuple[Edge, ...], int]]:
        """Returns the order that may be extended now: its record number, its edges, and the place
        at its end. Returns None if no order may be extended.
        """
        if master.held or master.anywhere or master.unknown or not master.commands:
            return None
        if master.open:
            last = master.open[-1]
            return (last.first, last.edges, last.edges[-1].destination) if last.edges else None
        return where_it_is(master)

    def new_orders(self, state: State, bounds: Bounds) -> Iterator[Tuple[str, Order, int]]:
        """Yields what the master may order now: the kind, the order, and the number of new edges in
        it.
        """
        master = state.master
        number = self._next_number(master, state.drawn)
        end = self.end(master)
        if end is not None and state.labels < bounds.edges:
            first, edges, place = end
            for to in {state.labels + 1, 0} - {place}:  # to a new place, or back
                edge = Edge(state.labels + 1, place, to)
                yield 'grant', Order(number, master.epoch, first, (*edges, edge)), 1
        if master.open and len(master.open[-1].edges) > 1 and not master.unknown:
            last = master.open[-1]
            yield 'shorten', Order(number, master.epoch, last.first, last.edges[:-1]), 0
        if (master.open or master.held or master.anywhere or master.unknown
                or not master.commands):
            yield 'stop', Order(number, 0, 0, ()), 0

    def _next_number(self, master: Master, drawn: int) -> int:
        return max(master.number, drawn if self._rules['clock'] else 0) + 1

    # -- everything that can happen ---------------------------------------------------------------

    def steps(self, state: State, bounds: Bounds) -> Iterator[Tuple[str, State]]:
        """Yields each event that is possible now, and the state after it."""
        yield from self._steps_of_vehicle(state, bounds)
        yield from self._arrivals(state, bounds)
        yield from self._steps_of_others(state, bounds)
        yield from self._steps_of_master(state, bounds)

    def _steps_of_vehicle(self, state: State, bounds: Bounds) -> Iterator[Tuple[str, State]]:
        vehicle = state.vehicle
        if vehicle.route or vehicle.rolling:
            yield 'drive', state._replace(vehicle=drive(vehicle))
        if vehicle.rolling:
            yield 'it comes to rest', state._replace(
                vehicle=vehicle._replace(rolling=(), giver=NOBODY))
        if vehicle.route:
            yield 'its route fails', state._replace(
                vehicle=without_route(vehicle)._replace(failed=True))
        said = _report(vehicle)
        if len(state.reports) < bounds.reports and not any(
                r[1:] == said[1:] for r in state.reports):
            yield f'report {said.sequence}: {said.motion.name}', state._replace(
                vehicle=vehicle._replace(sequence=said.sequence), reports=state.reports | {said})
        if vehicle.epoch < bounds.epochs:
            now = len(state.old_orders)
            past_master = new_epoch(without_route(vehicle), now)
            yield 'a stop past the master', state._replace(vehicle=past_master)
            yield 'restart without memory', state._replace(
                vehicle=past_master._replace(master=NOBODY))
            yield 'another giver moves it', state._replace(vehicle=Vehicle(
                vehicle.epoch + 1, NOBODY, place=AWAY, sequence=vehicle.sequence, stamp=now,
                moved_since=vehicle.sequence))

    def _arrivals(self, state: State, bounds: Bounds) -> Iterator[Tuple[str, State]]:
        vehicle, master = state.vehicle, state.master
        now = len(state.old_orders)
        for order in state.orders:
            for willing in (True, False):
                after = self.obey(vehicle, order, willing, now)
                if after != vehicle and after.epoch <= bounds.epochs:
                    yield (f'order {order.number} of {order.master} arrives'
                           f'{"" if willing else " and is refused"}', state._replace(vehicle=after))
        for message in state.old_orders:
            numbered = self.number_old_order(vehicle, message)
            if numbered is None:
                continue
            after = self.obey(vehicle, numbered, now=now)
            if after.epoch > bounds.epochs:
                continue
            is_too_old = after.order != vehicle.order and message.stamp <= vehicle.stamp
            yield f'old order {message.stamp} arrives', state._replace(
                vehicle=after._replace(stamp=max(vehicle.stamp, message.stamp)),
                flaw='D: a message of an old master is obeyed again' if is_too_old else '')
        for said in state.reports:
            heard = self.hear(master, said, state.drawn)
            if heard != master:
                yield f'report {said.sequence} arrives', state._replace(
                    master=heard,
                    unaware=state.unaware and not (master.unknown and not heard.unknown),
                    flaw='E: it hears of an order that its journal does not know'
                    if said.master == ME and _in_gap(heard, said) and not heard.unknown else '')

    def _steps_of_others(self, state: State, bounds: Bounds) -> Iterator[Tuple[str, State]]:
        vehicle = state.vehicle
        if state.others < bounds.others:
            number = state.others + 1  # other masters draw the same numbers as this one
            edges = _from_here(vehicle, OTHERS_LABELS + number)
            for name, route in (('orders a route', edges), ('stops', ())):
                order = Order(number, vehicle.epoch if route else 0, 0, route, OTHER)
                yield f'another master {name} ({number})', state._replace(
                    orders=state.orders | {order}, others=number)
        if len(state.old_orders) < bounds.old:
            stamp = len(state.old_orders) + 1
            label = OLD_LABELS + stamp
            if state.old_orders:  # the same route, and one edge more
                known = state.old_orders[-1].edges
                edges = (*known, Edge(label, known[-1].destination, label))
            else:
                edges = _from_here(vehicle, label)
            yield f'an old master orders a route ({stamp})', state._replace(
                old_orders=(*state.old_orders, OldOrder(stamp, edges)))

    def _steps_of_master(self, state: State, bounds: Bounds) -> Iterator[Tuple[str, State]]:
        master, journal = state.master, state.journal
        yield 'commit', state._replace(journal=master)
        yield 'the master restarts', state._replace(master=journal)
        if state.restores < bounds.restores and state.drawn > 0:
            begin = self._next_number(self.first_master(), state.drawn)
            for is_noticed in (True, False):
                doubts = is_noticed and self._rules['older']
                older = self.first_master((0, begin), begin if doubts else 0)
                yield ('the master starts with an older journal'
                       f'{"" if is_noticed else " and cannot know it"}'), state._replace(
                           master=older, journal=older, restores=state.restores + 1,
                           unaware=not is_noticed)
        if self._next_number(master, state.drawn) > bounds.orders:
            return
        for name, order, labels in self.new_orders(state, bounds):
            after = self.give(master, order)
            # A crash between storing and sending has the effect of an order that never arrives.
            yield f'{name} {order.number} {_text(order.edges)}', state._replace(
                master=after, journal=after if self._rules['commit'] else journal,
                labels=state.labels + labels, orders=state.orders | {order},
                drawn=max(state.drawn, order.number))

    # -- what must hold ---------------------------------------------------------------------------

    def flaw(self, state: State) -> str:
        """Returns which invariant does not hold, and why; empty: all invariants hold."""
        vehicle, master = state.vehicle, state.master
        if state.flaw:
            return state.flaw
        if master.anywhere or master.unknown or state.unaware:
            return ''
        allocated = self.allocation(master)
        if vehicle.giver == ME:
            for edge in (*vehicle.route, *vehicle.rolling):
                if edge not in allocated:
                    return f'A: it may drive {_text([edge])}, which is not allocated'
        if vehicle.moved_since >= master.sequence:
            return ''
        if vehicle.edge is not None and vehicle.edge not in allocated:
            return f'B: it is on {_text([vehicle.edge])}, which is not allocated'
        if vehicle.place is not None and vehicle.place != master.place and not any(
                vehicle.place in edge[1:] for edge in allocated):
            return f'B: it stands at {vehicle.place}, which is not allocated'
        return ''

    def is_live(self, state: State) -> bool:
        """Returns whether the vehicle comes to a new edge if messages arrive and nothing fails.

        The master grants an edge if it can. If it cannot, it repeats an order that no report shows
        yet, or sends a stop.
        """
        vehicle, master, drawn = state.vehicle, state.master, state.drawn
        for _ in range(12):
            while vehicle.route or vehicle.rolling:
                vehicle = drive(vehicle)
            said = _report(vehicle)
            vehicle = vehicle._replace(sequence=said.sequence)
            master = self.hear(master, said, drawn)
            if vehicle.place == NEW_LABEL:
                return True
            drawn = max(drawn, master.number)
            end = self.end(master)
            if end is not None and not any(edge.label == NEW_LABEL for edge in end[1]):
                first, edges, place = end
                order = Order(drawn + 1, master.epoch, first,
                              (*edges, Edge(NEW_LABEL, place, NEW_LABEL)))
            elif master.open and master.open[-1].number >= master.unknown:
                order = master.open[-1]
            else:
                order = Order(drawn + 1, 0, 0, ())
            if order.number > master.number:
                master = self.give(master, order)
            vehicle = self.obey(vehicle, order)
        return False

    def search(self, bounds: Bounds, most: Optional[int] = None, live: bool = False) -> Found:
        """Visits all states within the bounds, near ones first, until an invariant is violated.

        most -- the search ends after this number of states
        live -- liveness is checked, too, which takes several times as long
        """
        with _no_garbage_collection():
            return self._search(bounds, most, live)

    def _search(self, bounds: Bounds, most: Optional[int], live: bool) -> Found:
        start = State(master=self.first_master(), journal=self.first_master())
        came_from: Dict[State, Optional[State]] = {start: None}
        waiting: Deque[State] = deque([start])
        while waiting and (most is None or len(came_from) < most):
            state = waiting.popleft()
            for _, after in self.steps(state, bounds):
                if after in came_from:
                    continue
                came_from[after] = state
                flaw = self.flaw(after)
                if not flaw and live and not self.is_live(after):
                    flaw = 'C: the vehicle is never brought to a new edge'
                if flaw:
                    return Found(len(came_from), flaw, self._way(came_from, after, bounds))
                waiting.append(after)
        return Found(len(came_from))

    def _way(self, came_from: Dict[State, Optional[State]], end: State,
             bounds: Bounds) -> Tuple[str, ...]:
        """Returns the events from the start to this state."""
        way: List[str] = []
        before = came_from[end]
        while before is not None:
            way.append(next(event for event, after in self.steps(before, bounds) if after == end))
            end = before
            before = came_from[end]
        return tuple(reversed(way))


@contextlib.contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Stops garbage collection. It takes a third of the time and finds nothing, because states form
    no cycles.
    """
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def _text(edges: Iterable[Edge]) -> str:
    return ', '.join(f'{e.label} ({e.origin} to {e.destination})' for e in edges)


def without_route(vehicle: Vehicle) -> Vehicle:
    """Returns the vehicle after it lost its route.

    The vehicle comes to rest on its present edge or the next one.
    """
    if vehicle.edge is None:
        return vehicle._replace(route=(), rolling=(), giver=NOBODY)
    return vehicle._replace(route=(), rolling=(vehicle.route or vehicle.rolling)[:2])


def new_epoch(vehicle: Vehicle, now: int) -> Vehicle:
    return vehicle._replace(epoch=vehicle.epoch + 1, order=0, refused=0, done=0, failed=False,
                            stamp=now)


def _continues(vehicle: Vehicle, edges: Tuple[Edge, ...]) -> bool:
    """Returns whether these edges begin where the vehicle is."""
    if vehicle.edge is not None:
        return edges[0] == vehicle.edge  # the vehicle cannot leave its edge
    return edges[0].origin == vehicle.place


def drive(vehicle: Vehicle) -> Vehicle:
    """Returns the vehicle after it has driven another half edge.

    The record omits edges on which the vehicle only rolls.
    """
    edges = vehicle.route or vehicle.rolling
    if vehicle.edge is None:
        return vehicle._replace(edge=edges[0], place=None)
    rest = edges[1:]
    return vehicle._replace(
        edge=None, place=vehicle.edge.destination, done=vehicle.done + bool(vehicle.route),
        route=rest if vehicle.route else (), rolling=() if vehicle.route else rest,
        giver=vehicle.giver if rest else NOBODY)


def _report(vehicle: Vehicle) -> Report:
    return Report(vehicle.sequence + 1, vehicle.epoch, vehicle.master, vehicle.order,
                  vehicle.refused, vehicle.done, motion_of(vehicle), vehicle.failed, vehicle.place,
                  vehicle.edge)


def motion_of(vehicle: Vehicle) -> Motion:
    if not vehicle.route and not vehicle.rolling:
        return Motion.STANDING
    if vehicle.master == NOBODY:
        return Motion.UNKNOWN
    if vehicle.giver != vehicle.master:
        return Motion.MOVED
    return Motion.ON_ROUTE if vehicle.route else Motion.COMING_TO_REST


def _in_gap(master: Master, said: Report) -> bool:
    """Returns whether a report says that the vehicle may obey an order that the journal lacks.

    A vehicle that has taken a newer order does not obey the order that the journal lacks.
    """
    low, high = master.gap
    return low < max(said.order, said.refused) and said.order < high and (
        low < said.order or said.refused < high)


def where_it_is(master: Master) -> Tuple[int, Tuple[Edge, ...], int]:
    """Returns the result of `Model.end` for a vehicle without a route."""
    if master.edge is not None:  # the order begins with the rest of the edge where the vehicle is
        return master.done, (master.edge,), master.edge.destination
    assert master.place is not None
    return master.done, (), master.place


def _from_here(vehicle: Vehicle, label: int) -> Tuple[Edge, ...]:
    """Returns a route of another master. If the vehicle is on an edge, the route begins with it."""
    if vehicle.edge is None:
        assert vehicle.place is not None
        return (Edge(label, vehicle.place, label),)
    return vehicle.edge, Edge(label, vehicle.edge.destination, label)
