"""The master's end of the route protocol: what the master's orders still let one vehicle do.

State
    epoch, report  -- of the newest report
    number         -- of the last order that was given
    order, refused -- numbers in the newest report, for this master and epoch: the last order that
                      was taken, and the highest of the orders that were refused
    done           -- number, in the route record, of the first edge that is not driven to its end
    open           -- the orders that the vehicle follows, or may follow later
    behind         -- edges that the vehicle has driven, but perhaps not left completely
    held           -- edges that the vehicle may still be on, until it stands
    is_anywhere    -- another giver moves it; only its location says where it is
    commands       -- the vehicle counts this master's orders
    unknown        -- if the journal is an older copy: number of an order; the vehicle may be
                      anywhere until it stands after this order. 0: the journal is not an older copy
    gap            -- two numbers; orders with numbers between them are in no journal that this run
                      has read

What a report does (`hear`)
    | the report                                | what follows                                     |
    |-------------------------------------------|--------------------------------------------------|
    | is not newer than the reports before it   | nothing                                          |
    | names another master                      | its `order`, `refused` and record count as 0     |
    | shows order n                             | orders below n are not open any more             |
    | shows that n was refused                  | orders up to n, above `order`, are not open      |
    | shows that the route of order n is lost   | order n is not open                              |
    | has a new epoch                           | no route is open any more; stops stay open       |
    | STANDING                                  | nothing is behind or held                        |
    | on the route of an open order, same epoch | nothing is held                                  |
    | anything else                             | edges of orders that are not open any more, and  |
    |                                           | in a new epoch all edges, are held               |
    | moved, or on the route of another master  | the vehicle is anywhere, until it is STANDING or |
    |                                           | on the route of an open order                    |
    | shows a number in the gap                 | the vehicle is unknown, until it is STANDING     |
    |                                           | after a stop that is given from now on           |
    | shows a number above `number`             | all numbers up to SKIPPED above it are in the gap|

Invariants
    - A vehicle that is neither anywhere nor unknown is on an edge of `may_be_on` or at the place in
      the newest report. Orders of this master bring it to no other edge.
    - A route is given only if nothing is held, the vehicle is neither anywhere nor unknown, and it
      counts this master's orders. A stop may be given at any time.

`test/test_master.py` searches all states that these functions can reach with a vehicle.
The state must be on the disk before an order is sent.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import takewhile
from typing import Any, Dict, NamedTuple, Optional, Tuple

from route_protocol.messages import WrongReport
from route_protocol.order_rules import MAXIMUM_EDGES
from route_protocol.values import (
    LARGEST_RECORD_NUMBER,
    NO_REASON,
    EpochCause,
    Motion,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteReport,
)

REPEAT = 1.0  # s after which an order that no report shows is sent again
SKIPPED = 2 ** 40
"""How many numbers a master skips if a report shows an order that it does not know: 35 years in ms.

If the journal was lost and the clock set back, orders with larger numbers than any that the vehicle
shows may be on their way. The clock that gave these numbers was ahead of the present clock, but by
less than 35 years.
"""
_LARGEST_LABEL = 2 ** 31 - 1
# After an edge with a larger number, too few numbers are left for a route of MAXIMUM_EDGES.
_LAST_EDGE = LARGEST_RECORD_NUMBER - MAXIMUM_EDGES

SAID_NONE = Reason(ReasonCode.OTHER, 'it gave no reason')


class Step(NamedTuple):
    """An edge (signed id) at its place in the route record."""

    number: int
    edge: int


class Order(NamedTuple):
    """An order that was given.

    epoch -- the epoch in which the order was decided; 0 for a stop
    first -- record number of `edges[0]`
    """

    number: int
    epoch: int
    first: int
    edges: Tuple[int, ...]
    route_id: int = 0

    @property
    def end(self) -> int:
        """The record number that follows the last edge."""
        return self.first + len(self.edges)

    def steps(self, begin: int) -> Tuple[Step, ...]:
        """Returns the edges from record number `begin` on."""
        skipped = max(begin - self.first, 0)
        return tuple(Step(self.first + skipped + k, edge)
                     for k, edge in enumerate(self.edges[skipped:]))

    def sent_by(self, master: str, stamp: int = 0, speed: float = 0.0) -> RouteOrder:
        """Returns the order as this master sends it.

        speed -- m/s that the vehicle does not exceed because of its load; 0: no such limit
        """
        return RouteOrder(self.route_id, self.edges, stamp, known_epoch=self.epoch,
                          order=self.number, first=self.first, master=master, speed=speed)


@dataclass(frozen=True)
class MasterState:
    """The state of the master's end of the protocol for one vehicle.

    The docstring of the module explains it.

    Values that are derived from the state are computed once, because masters read them many times
    for each report.
    """

    epoch: int = 0
    report: int = 0
    number: int = 0
    order: int = 0
    refused: int = 0
    done: int = 0
    open: Tuple[Order, ...] = ()
    behind: Tuple[Step, ...] = ()
    held: Tuple[Step, ...] = ()
    is_anywhere: bool = False
    commands: bool = False
    unknown: int = 0
    gap: Tuple[int, int] = (0, 0)

    def after(self, report: int) -> MasterState:
        """Returns the same state after a report that changes nothing but its number.

        The copy keeps the derived values, so that they are not computed again for each report.
        """
        found = object.__new__(MasterState)
        vars(found).update(vars(self), report=report)
        return found

    @cached_property
    def may_be_on(self) -> Tuple[Step, ...]:
        """All edges on which the vehicle may be, or onto which orders may still bring it."""
        found = dict.fromkeys((*self.behind, *self.held))
        for order in self.open:
            found.update(dict.fromkeys(order.steps(self.done)))
        return tuple(found)

    @cached_property
    def farthest(self) -> Optional[Order]:
        """The open route that leads farthest; None: no route is open."""
        routes = [order for order in self.open if order.edges]
        return max(routes, key=lambda order: order.end) if routes else None

    @cached_property
    def ahead(self) -> Tuple[int, ...]:
        """The edges of the route `farthest`, from the edge that the vehicle drives now."""
        route = self.farthest
        return () if route is None else tuple(step.edge for step in route.steps(self.done))

    @cached_property
    def shown(self) -> int:
        """How many edges at the beginning of `ahead` are on the route that the vehicle reports."""
        followed = next((order for order in self.open if order.number == self.order), None)
        known = () if followed is None else followed.steps(self.done)
        return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1].edge,
                                        zip(self.ahead, known)))

    @cached_property
    def end(self) -> int:
        """The record number that follows the last edge of `ahead`."""
        return self.done + len(self.ahead)

    @cached_property
    def pending(self) -> Optional[Order]:
        """The newest order, which must be repeated; None: a report has shown it."""
        last = self.open[-1] if self.open else None
        return last if last is not None and last.number > self.order else None

    @property
    def is_stopping(self) -> bool:
        """Whether the newest order is a stop that no report shows yet."""
        return self.pending is not None and not self.pending.edges

    @property
    def takes_away(self) -> bool:
        """Whether the pending order stops the vehicle, or shortens its route."""
        return self.pending is not None and self.pending.end < self.end or self.is_stopping

    @property
    def is_ready(self) -> bool:
        """Whether a route may be given now."""
        return self.commands and not (self.held or self.is_anywhere or self.unknown
                                      or self.takes_away)

    @property
    def may_drive(self) -> bool:
        """Whether the vehicle may drive now, or later, by an order of this master."""
        return bool(self.ahead or self.held)


@dataclass(frozen=True)
class News:
    """What a report has changed.

    is_new   -- the report is newer than all earlier ones
    cause    -- why a new epoch began; None: the epoch is not new
    passed   -- edges that were driven since the previous report, in driving order
    took     -- the report shows a taken order that no report has shown before
    failed   -- why the route is lost; no reason: it is not lost, or its loss was known
    refused  -- why open orders were refused; no reason: none was refused
    was_shorter -- the newest refused order was a stop, or would have shortened the route
    stands   -- the vehicle stands, and the report has its place
    is_older -- the journal is an older copy: the report shows an order that is not in it
    is_repeat -- the report changes nothing except its own number
    """

    is_new: bool = False
    cause: Optional[EpochCause] = None
    passed: Tuple[int, ...] = ()
    took: bool = False
    failed: Reason = NO_REASON
    refused: Reason = NO_REASON
    was_shorter: bool = False
    stands: bool = False
    is_older: bool = False
    is_repeat: bool = False


OLD_NEWS = News()


class _Reading(NamedTuple):
    """What a report says about the orders of this master.

    order, refused -- the numbers in the report; 0 if it names another master
    is_new -- the report has a new epoch
    is_older -- the report shows a number that the journal lacks
    shown -- the open order with the number `order`
    failed -- the route of order `order` is lost
    """

    is_mine: bool
    order: int
    refused: int
    is_new: bool
    is_older: bool
    shown: Optional[Order]
    failed: bool


def _read(state: MasterState, said: RouteReport, me: str) -> _Reading:
    is_mine = said.master == me
    order, refused = (said.order, said.refused) if is_mine else (0, 0)
    return _Reading(is_mine, order, refused, said.epoch != state.epoch,
                    is_mine and _is_in_gap(state, said),
                    next((one for one in state.open if one.number == order), None),
                    order > 0 and said.is_failed)


def hear(state: MasterState, said: RouteReport, me: str, clock: int,
         is_located: bool = True) -> Tuple[MasterState, News]:
    """Returns the state after a report, and what has changed. Raises WrongReport.

    me         -- name of this master
    clock      -- ms since 1970
    is_located -- the report has the vehicle's place; False: then STANDING does not count
    """
    if said.number <= state.report:
        return state, OLD_NEWS
    given, state = state, _with_unknown_numbers(state, said, me)
    read = _read(state, said, me)
    _check(state, said, read)
    still = tuple(one for one in state.open if _is_still_open(one, said, read))
    stands = said.motion is Motion.STANDING and is_located
    knows_where = stands or _is_on_open_route(said, read, still)
    passed = _passed(state, said, read)
    behind = () if stands or read.is_new else (*state.behind, *passed)
    done = state.end + 1 if read.is_new else state.done
    told: Dict[str, Any] = {
        'epoch': said.epoch, 'order': read.order, 'refused': read.refused,
        'done': said.done if read.order else done, 'open': still, 'behind': behind,
        'held': () if knows_where else _held(state, still, read.is_new),
        'is_anywhere': _may_be_anywhere(state, said, read, stands, knows_where),
        'commands': read.is_mine, 'unknown': _unknown(state, read, stands, clock)}
    is_repeat = state is given and told.items() <= vars(state).items()
    after = (state.after(said.number) if is_repeat
             else replace(state, report=said.number, **told))
    return after, _news(state, said, read, passed, stands, is_repeat)


def _may_be_anywhere(state: MasterState, said: RouteReport, read: _Reading, stands: bool,
                     knows_where: bool) -> bool:
    """Returns whether the vehicle may be at a place to which no order of this master led."""
    return not stands and _is_moved_otherwise(said, read.is_mine) or (
        state.is_anywhere and not knows_where)


def _with_unknown_numbers(state: MasterState, said: RouteReport, me: str) -> MasterState:
    """Returns the state with a new gap if a report shows a number that this master never drew."""
    newest = max(said.order, said.refused)
    if said.master != me or newest <= state.number or _is_in_gap(state, said):
        return state
    return replace(state, gap=(state.number, newest + SKIPPED))


def _is_still_open(one: Order, said: RouteReport, read: _Reading) -> bool:
    """Returns whether the vehicle may still follow an order that was open before the report."""
    if one.edges and one.epoch != said.epoch:
        return False
    return one.number > read.refused if one.number > read.order else (
        one.number == read.order and not read.failed)


def _is_on_open_route(said: RouteReport, read: _Reading, still: Tuple[Order, ...]) -> bool:
    """Returns whether the vehicle is on the route of an open order, in the same epoch."""
    return read.shown in still and not read.is_new and said.motion in (
        Motion.ON_ROUTE, Motion.STANDING)


def _is_moved_otherwise(said: RouteReport, is_mine: bool) -> bool:
    """Returns whether something other than an order of this master moves the vehicle."""
    return said.motion is Motion.MOVED or not is_mine and said.motion in (
        Motion.ON_ROUTE, Motion.COMING_TO_REST)


def _passed(state: MasterState, said: RouteReport, read: _Reading) -> Tuple[Step, ...]:
    """Returns the edges of the vehicle's order that it has driven since the previous report."""
    if read.shown is None or not read.order or read.is_new or said.done <= state.done:
        return ()
    return tuple(step for step in read.shown.steps(state.done) if step.number < said.done)


def _held(state: MasterState, still: Tuple[Order, ...], is_new: bool) -> Tuple[Step, ...]:
    """Returns the edges that are held until the vehicle stands."""
    gone = state.may_be_on if is_new else tuple(
        step for one in state.open if one not in still for step in one.steps(state.done))
    return tuple(dict.fromkeys((*state.held, *gone)))


def _unknown(state: MasterState, read: _Reading, stands: bool, clock: int) -> int:
    if read.is_older:
        return state.unknown if state.unknown >= state.gap[1] else next_number(state, clock)
    return 0 if stands and read.order >= state.unknown else state.unknown


def _news(state: MasterState, said: RouteReport, read: _Reading, passed: Tuple[Step, ...],
          stands: bool, is_repeat: bool) -> News:
    refusals = [one for one in state.open if read.order < one.number <= read.refused]
    lost = read.failed and read.shown is not None and bool(read.shown.edges)
    return News(
        True, said.cause if read.is_new else None, tuple(step.edge for step in passed),
        read.order > (0 if read.is_new else state.order),
        (said.reason or SAID_NONE) if lost else NO_REASON,
        (said.refusal or SAID_NONE) if refusals else NO_REASON,
        bool(refusals) and refusals[-1].end < state.end, stands, read.is_older, is_repeat)


def _is_in_gap(state: MasterState, said: RouteReport) -> bool:
    """Returns whether the vehicle may obey an order that the journal lacks, according to a report.

    If a newer order was taken, the vehicle obeys none of these orders.
    """
    low, high = state.gap
    return low < max(said.order, said.refused) and said.order < high and (
        low < said.order or said.refused < high)


def _check(state: MasterState, said: RouteReport, read: _Reading) -> None:
    """Raises WrongReport for a report that contradicts what was ordered or reported before."""
    if read.is_older:
        return
    order, shown = read.order, read.shown
    if order and said.done > _LAST_EDGE:
        raise WrongReport(f'its route record is at number {said.done}: too few numbers are left '
                          'for another route')
    if read.is_new:
        return
    if order < state.order:
        raise WrongReport(f'it shows order {order} after order {state.order}')
    if state.order and said.done < state.done:
        raise WrongReport(f'it shows edge number {said.done} after number {state.done}')
    if shown is not None and (said.first, said.edges) != (
            (shown.first, shown.edges) if shown.edges else (said.first, ())):
        raise WrongReport(f'its edges are not those of order {order}')


def left(state: MasterState, number: int) -> MasterState:
    """Returns the state after the vehicle has certainly left all edges before a record number."""
    behind = tuple(step for step in state.behind if step.number >= number)
    return state if behind == state.behind else replace(state, behind=behind)


def give_route(state: MasterState, number: int, edges: Tuple[int, ...],
               route_id: int) -> MasterState:
    """Returns the state after an order to drive these edges, beginning with the present edge."""
    order = Order(number, state.epoch, state.done, edges, route_id)
    return replace(state, number=number, open=(*state.open, order))


def give_stop(state: MasterState, number: int, route_id: int) -> MasterState:
    """Returns the state after a stop."""
    order = Order(number, 0, state.done, (), route_id)
    return replace(state, number=number, open=(*state.open, order))


def next_number(state: MasterState, clock: int) -> int:
    """Returns the number of the next order, above all numbers that earlier runs may have drawn.

    clock -- ms since 1970, so that no number is drawn twice even with an older journal
    """
    return max(state.number + 1, clock, state.gap[1])


def label_of(number: int) -> int:
    """Returns the `route_id` of a route or stop that begins with this order."""
    return number % _LARGEST_LABEL + 1
