"""The vehicle's end of the route protocol: which orders it takes, and what it reports.

State
    epoch    -- number of the epoch; when orders on their way must not be obeyed any more, a new
                epoch begins
    master   -- the program whose orders are counted; None: none yet. OLD_MASTER stands for all
                masters that do not number their orders
    order    -- number of the last order that was taken in this epoch
    refused  -- highest number of an order that was refused in this epoch
    done     -- number, in the route record, of the first edge that is not driven to its end
    route    -- the edges of `order`, counted in the record from `first` on, and its phase

Events and what follows
    | event                      | condition                        | answer                       |
    |----------------------------|----------------------------------|------------------------------|
    | stop that has no number or |                                  | taken: a new epoch begins    |
    | cannot be counted          |                                  |                              |
    | route that cannot be       |                                  | refused, but not counted     |
    | counted                    |                                  |                              |
    | stop or route of `master`  | number <= order or <= refused    | ignored                      |
    | stop of `master`           | newer                            | taken, in the same epoch     |
    | stop of another master     |                                  | taken: a new epoch begins    |
    | route                      | not decided in this epoch        | refused                      |
    | route of `master`          | `done` is not in first ... end   | refused                      |
    | route of `master`          | a route is RUNNING, and the new  | refused                      |
    |                            | route does not continue with the |                              |
    |                            | edge under way                   |                              |
    | route of another master    | the vehicle can begin it         | taken: a new epoch begins    |
    | route of another master    | the vehicle cannot               | refused, but not counted     |
    | any other route            | the vehicle can drive it         | taken                        |
    | any other route            | the vehicle cannot               | refused: `refused` grows     |
    | route fails                | RUNNING                          | FAILED; `order` stays        |
    | another giver, restart ... |                                  | a new epoch; RUNNING: FAILED |
    | the master itself moves    | COMPLETE                         | STOPPED: the next route does |
    | the vehicle with no route  |                                  | not go on with this one      |

An order cannot be counted if it does not name its master, or if its number is the largest that a
message can carry.

The first order in an epoch gives a number to the edge on which the vehicle is. From then on each
edge has the next number, so a route may pass a place twice. A new epoch sets `order` and `refused`
to 0 and keeps `master`. After a start without memory, there is no `master`.

Invariants
    - `order`, `refused` and the number of reports only grow within an epoch.
    - A route in force was decided in this epoch, or it began this epoch.
    - A stop is never refused, even if it names an older epoch.

The caller judges two things that only the caller can know: whether the route begins where the
vehicle is, and whether the vehicle can brake in time. The caller stores `state` before the vehicle
acts. A vehicle that lost its route may still roll: new routes wait until it stands.
"""
from __future__ import annotations

import secrets
import time
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Callable, Optional, Tuple

from route_protocol.order_rules import edge_states
from route_protocol.values import (
    LARGEST_NUMBER,
    LARGEST_RECORD_NUMBER,
    NO_REASON,
    OVERRULED,
    EpochCause,
    Motion,
    Phase,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
    SymbolicPose,
    VehicleLocation,
)

OLD_MASTER = ''
"""Stands for all masters that do not number their orders; `old_masters` numbers them."""

SKIPPED_REPORTS = 60_000
"""How many report numbers a restart skips (1 min in ms), because the last numbers may not be
stored.
"""


def draw_epoch() -> int:
    """Returns the number of a new epoch: random, and never 0."""
    return secrets.randbits(63) or 1


def milliseconds() -> int:
    """Returns ms since 1970."""
    return time.time_ns() // 1_000_000


@dataclass(frozen=True)
class VehicleState:
    """The state of the vehicle's end of the protocol; the docstring of the module explains it.

    It is one value, so that it is stored as a whole.
    """

    epoch: int
    cause: EpochCause = EpochCause.RESTART
    master: Optional[str] = None
    order: int = 0
    refused: int = 0
    refusal: Reason = NO_REASON
    done: int = 0
    route_id: int = 0
    first: int = 0
    edges: Tuple[int, ...] = ()
    phase: Phase = Phase.STOPPED
    reason: Reason = NO_REASON
    report: int = field(default=0, compare=False)
    """Number of the last report."""

    @property
    def is_running(self) -> bool:
        """Whether the vehicle drives a route."""
        return self.phase is Phase.RUNNING

    @property
    def completed(self) -> int:
        """How many edges of the route have been driven."""
        return min(max(self.done - self.first, 0), len(self.edges))

    @property
    def ahead(self) -> Tuple[int, ...]:
        """The edge that the vehicle drives now, and the edges of the route after it."""
        return self.edges[self.completed:]


class Answer(Enum):
    """The kind of answer to an order that has arrived."""

    IGNORED = 'it is not newer than the last one'
    STOP = 'it stops the vehicle'
    REFUSED = 'it is refused'
    ROUTE = 'it is taken, if the vehicle can drive it'


@dataclass(frozen=True)
class Judgement:
    """The answer to an order.

    reason  -- why the order is refused
    done    -- record number of the first edge of `rest`
    rest    -- the edges that the vehicle would still drive
    goes_on -- `rest` continues the route that the vehicle drives or has completed
    """

    answer: Answer
    reason: Reason = NO_REASON
    done: int = 0
    rest: Tuple[int, ...] = ()
    goes_on: bool = False


_IGNORED, _STOP = Judgement(Answer.IGNORED), Judgement(Answer.STOP)


class Vehicle:
    """The vehicle's end of the route protocol; the docstring of the module explains it.

    draw  -- returns the number of a new epoch; this number was never used before
    clock -- returns ms since 1970; the number of a report is never below this time
    state -- the state from before a restart; None: the vehicle starts without its memory
    """

    def __init__(self, draw: Callable[[], int], clock: Callable[[], int],
                 state: Optional[VehicleState] = None) -> None:
        self._draw, self._clock = draw, clock
        self.state = state if state is not None else VehicleState(draw())

    def resume(self, state: VehicleState) -> None:
        """Continues with the state from before a restart.

        Skips report numbers, because the last ones may not have been stored.
        """
        self.state = replace(state, report=_behind(state.report))

    def forget(self, state: VehicleState, reason: Reason) -> None:
        """Starts without memory of orders. Reports still show the old route.

        state -- a state from before the restart, but perhaps not the last one
        reason -- why a running route fails
        """
        self.resume(replace(state, master=None))
        self.begin_epoch(EpochCause.RESTART, reason)

    # -- orders -----------------------------------------------------------------------------------

    def judge(self, order: RouteOrder) -> Judgement:
        """Returns the answer to an order with a number, or to a stop without a number."""
        state = self.state
        if _is_past_master(order):
            assert order.is_stop, 'old_masters gives each route a number'
            return _STOP
        if order.master == state.master and order.order <= max(state.order, state.refused):
            return _IGNORED
        if order.is_stop:
            return _STOP
        wrong = _wrong(order)
        if wrong:
            return Judgement(Answer.REFUSED, wrong)
        if order.known_epoch != state.epoch:
            return Judgement(Answer.REFUSED, OVERRULED)
        if self._is_fresh(order):
            return Judgement(Answer.ROUTE, done=order.first, rest=order.edges)
        if not order.first <= state.done <= order.end:
            return Judgement(Answer.REFUSED, Reason(
                ReasonCode.WRONG_CHANGE,
                f'its edges have the numbers {order.first} to {order.end - 1} in the route record, '
                f'but the vehicle is at number {state.done}'))
        rest = order.edges[state.done - order.first:]
        if state.is_running and rest[:1] != state.ahead[:1]:
            return Judgement(Answer.REFUSED, Reason(
                ReasonCode.WRONG_CHANGE,
                f'it must go on with the edge under way, {state.ahead[0]}'))
        if not rest and state.phase is not Phase.COMPLETE:
            return Judgement(Answer.REFUSED, Reason(
                ReasonCode.WRONG_CHANGE, 'it ends before the edge on which the vehicle stands'))
        return Judgement(Answer.ROUTE, NO_REASON, state.done, rest,
                         state.phase in (Phase.RUNNING, Phase.COMPLETE))

    def _is_fresh(self, order: RouteOrder) -> bool:
        """Returns whether no order of this master was taken before in this epoch."""
        return self._takes_over(order) or not self.state.order

    def _takes_over(self, order: RouteOrder) -> bool:
        return self.state.master not in (None, order.master)

    def stop(self, order: RouteOrder) -> None:
        """Takes a stop."""
        if _is_past_master(order):
            self.begin_epoch(EpochCause.STOP)
        elif self._takes_over(order):
            self.begin_epoch(EpochCause.OTHER_MASTER)
        state, done = self.state, self.state.done
        if not _is_past_master(order):
            done = state.done if state.order else order.first
            state = replace(state, master=order.master, order=order.order)
        self.state = replace(state, route_id=order.route_id, done=done, first=done, edges=(),
                             phase=Phase.STOPPED, reason=NO_REASON)

    def take_order(self, order: RouteOrder, done: int) -> None:
        """Takes a route.

        done -- record number of the edge on which the vehicle is, as `judge` has returned it
        """
        if self._takes_over(order):
            self.begin_epoch(EpochCause.OTHER_MASTER)
        self.state = replace(
            self.state, master=order.master, order=order.order, done=done, route_id=order.route_id,
            first=order.first, edges=order.edges, reason=NO_REASON,
            phase=Phase.RUNNING if done < order.end else Phase.COMPLETE)

    def refuse(self, order: RouteOrder, reason: Reason) -> RouteRefusal:
        """Refuses a route. Returns the message for people."""
        if (_can_be_counted(order) and not self._takes_over(order)
                and order.order > self.state.refused):
            self.state = replace(self.state, master=order.master, refused=order.order,
                                 refusal=reason)
        return RouteRefusal(order.route_id, order.edges, reason, order.order)

    # -- the route --------------------------------------------------------------------------------

    def complete(self, completed: int) -> None:
        """Notes how many edges of the running route have been driven."""
        state = self.state
        done = min(max(state.first + completed, state.done), state.first + len(state.edges))
        if state.is_running and done != state.done:
            self.state = replace(state, done=done, phase=Phase.RUNNING if (
                done < state.first + len(state.edges)) else Phase.COMPLETE)

    def fail(self, reason: Reason) -> None:
        """Makes a running route FAILED."""
        if self.state.is_running:
            self.state = replace(self.state, phase=Phase.FAILED, reason=reason)

    def leave_route(self) -> None:
        """Notes that the master itself moved or stopped the vehicle without a route. The master
        decides its next orders later than this, so no epoch begins.
        """
        if self.state.phase is Phase.COMPLETE:
            self.state = replace(self.state, phase=Phase.STOPPED)

    def begin_epoch(self, cause: EpochCause, reason: Reason = NO_REASON) -> None:
        """Begins a new epoch: the vehicle obeys no order that is on its way now.

        reason -- why a running route fails
        """
        if self.state.is_running:
            self.fail(reason)
        self.state = replace(self.state, epoch=self._draw(), cause=cause, order=0, refused=0,
                             refusal=NO_REASON)

    # -- reports ----------------------------------------------------------------------------------

    def report(self, stamp: int, pose: SymbolicPose, location: Optional[VehicleLocation],
               motion: Motion, reason: Reason = NO_REASON,
               unready: ReasonCode = ReasonCode.NONE) -> RouteReport:
        """Returns the next report.

        stamp, pose, location -- the vehicle's place, and when it was there
        reason  -- why a stop is not obeyed yet
        unready -- why the vehicle refuses every route now
        """
        number = min(max(self.state.report + 1, self._clock()), LARGEST_NUMBER)
        state = self.state = replace(self.state, report=number)
        return RouteReport(
            stamp, state.route_id, state.edges,
            edge_states(state.edges, state.completed, state.phase), pose, state.reason or reason,
            location, state.epoch, state.cause, state.master or '', state.order, state.refused,
            state.refusal, state.first, motion, number, unready)


def _is_past_master(order: RouteOrder) -> bool:
    """Returns whether an order has no number, or is a stop that cannot be counted."""
    return not order.order or order.is_stop and not _can_be_counted(order)


def _can_be_counted(order: RouteOrder) -> bool:
    return 0 < order.order < LARGEST_NUMBER and order.master != OLD_MASTER


def _behind(report: int) -> int:
    """Returns a number above all report numbers that may have been drawn since `report`."""
    return min(report + SKIPPED_REPORTS, LARGEST_NUMBER)


def _wrong(order: RouteOrder) -> Reason:
    """Returns why every vehicle refuses a route with a number; no reason: it need not be refused.
    """
    if not order.known_epoch:
        return Reason(ReasonCode.OVERRULED, 'it has a number, but does not name the epoch in which '
                                            'it was decided (known_epoch)')
    if order.master == OLD_MASTER:
        return Reason(ReasonCode.OTHER, 'it has a number, but does not name its master')
    if order.order >= LARGEST_NUMBER:
        return Reason(ReasonCode.OTHER, f'its number is {order.order}: no later order could have a '
                                        'larger one')
    if order.end > LARGEST_RECORD_NUMBER:
        return Reason(ReasonCode.WRONG_ROUTE, f'its first edge has the number {order.first}: '
                                              'record numbers end before that')
    return NO_REASON
