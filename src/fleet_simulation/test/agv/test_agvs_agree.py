"""The AGV of `agv_sim` and the plain AGV, which share no code, answer orders in the same way."""
from __future__ import annotations

import math
from dataclasses import replace
from random import Random
from typing import Callable, List, NamedTuple, Optional, Tuple, Type

import pytest
from agv_builders import GRAPH, TICK, vehicle_at
from fleet_builders import AGV
from hypothesis import example, given
from hypothesis import strategies as st

from route_protocol.values import (
    EMERGENCY_STOP,
    TAKEN_OVER,
    Motion,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteRefusal,
    RouteReport,
)
from world.plain_agv import Agv

MIDDLE = 2.0    # m; distance to the middle of an edge; there the AGV of `agv_sim` has full speed
BRAKING = 1.0   # m, the braking distance of the AGV of `agv_sim` there
FAULT = Reason(ReasonCode.OTHER, 'a broken belt')
EVENTS = 30


class Sent(NamedTuple):
    """An order, and the number of an event; this event began the epoch that the order names."""

    order: RouteOrder
    epoch: int


class Pair:
    """Both AGVs, at the same place, under the same events."""

    def __init__(self, random: Random, plain: Type[Agv]) -> None:
        self.random, self.time = random, 0.0
        self.one = vehicle_at(1, GRAPH, lambda: int(1000.0 * self.time))
        self.other = plain(GRAPH, AGV, 1)
        self.other.near = 0.02
        self.epochs: List[Tuple[int, int]] = []
        self.sent: List[Sent] = []
        self.number = 0
        self.reported = 0, 0  # numbers of the newest reports

    # -- events -----------------------------------------------------------------------------------

    def happens(self) -> str:
        """Lets a random event happen, and returns a description of the event."""
        act = self.random.choice((
            self.order, self.order, self.order, self.order, self.repeat, self.to_middle,
            self.to_middle, self.to_middle, self.settle, self.stop, self.stop_past_master,
            self.fail, self.emergency, self.taken_over, self.restart, self.put_elsewhere))
        what = act()
        self._advance(0.0)
        return f'{act.__name__} {what or ""}'

    def order(self) -> str:
        """Sends a route that fits, or a wrong route."""
        state, random = self.one.state, self.random
        edges, first = random.choice((
            (state.edges + self._walk(state.edges[-1:]), state.first),
            (state.ahead + self._walk(state.ahead[-1:]), state.done),
            (state.edges[:state.completed + 1], state.first),
            (self._walk(()), state.done),
            (self._walk(()), state.done),
            (self._walk(()), random.randrange(4)),
            (tuple(random.choice((-4, -3, -2, -1, 1, 2, 3, 4)) for _ in range(2)), state.done)))
        self.number += random.choice((1, 1, 1, 2))
        number = self.number if random.random() < 0.85 else random.randint(1, self.number)
        is_late = random.random() < 0.1
        epoch = random.randrange(len(self.epochs)) if is_late else len(self.epochs) - 1
        return self._send(Sent(RouteOrder(number, edges, order=number, first=first,
                                          master=self._master()), epoch))

    def stop(self) -> str:
        self.number += 1
        return self._send(Sent(RouteOrder(self.number, (), order=self.number, first=self.number,
                                          master=self._master()), 0))

    def stop_past_master(self) -> str:
        return self._send(Sent(RouteOrder(0, ()), 0))

    def repeat(self) -> str:
        """Sends an earlier order again."""
        return self._send(self.random.choice(self.sent)) if self.sent else ''

    def fail(self) -> None:
        self.one.fail(FAULT)
        self.other.fail(FAULT)

    def emergency(self) -> None:
        self.one.press_emergency_stop()
        self.one.release_emergency_stop()
        self.other.fail(EMERGENCY_STOP)

    def taken_over(self) -> None:
        self.one.take_over()
        self.other.fail(TAKEN_OVER)

    def restart(self) -> None:
        """Switches both AGVs off and on again, without memory."""
        self.settle()
        self._advance(TICK)
        self.one.leave()
        self.one.join()
        self.other.forget()

    def put_elsewhere(self) -> None:
        vertex = self.random.choice(list(GRAPH.vertices))
        self.one.put_on(vertex)
        self.other.move_to(GRAPH.edges_from(vertex)[0], 0.0)
        self.other.braking = 0.0

    def to_middle(self) -> None:
        """Lets both AGVs drive to the middle of this edge or of the next edge, or to the end of the
        route.
        """
        state = self.one.state
        if not state.is_running:
            return
        number = state.done + (1 if self.one.drive.arc > MIDDLE - 0.1 else 0)
        if number == state.first + len(state.edges):
            self.settle()
            return
        self._until(lambda: self.one.state.done == number and self.one.drive.arc >= MIDDLE,
                    lambda: self.other.knows['done'] == number and self.other.arc >= MIDDLE)
        self.other.braking = BRAKING

    def settle(self) -> None:
        """Waits until both AGVs stand."""
        self._until(lambda: self.one.motion is Motion.STANDING,
                    lambda: self.other.motion is Motion.STANDING)
        self.other.braking = 0.0

    # -- what they say ----------------------------------------------------------------------------

    def difference(self) -> Optional[str]:
        """Returns how the newest reports of the AGVs differ, or another error in these reports."""
        one, other = self.one.report(), self.other.told(0)
        self.epochs.append((one.epoch, other.epoch))
        pairs, ones, others = set(self.epochs), *map(set, zip(*self.epochs))
        if not len(pairs) == len(ones) == len(others):
            return 'only one of them began a new epoch'
        numbers, self.reported = self.reported, (one.number, other.number)
        for name, before, now in zip(('agv_sim', 'plain_agv'), numbers, self.reported):
            if now <= before:
                return f'{name} repeats the number {now} of a report'
        for name in ('order', 'refused', 'master', 'cause', 'first', 'edges', 'states', 'motion',
                     'done', 'is_failed'):
            if getattr(one, name) != getattr(other, name):
                return f'{name}: {getattr(one, name)} and {getattr(other, name)}'
        assert one.location is not None and other.location is not None
        apart = math.dist((one.location.x, one.location.y), (other.location.x, other.location.y))
        return f'they are {apart:.2f} m apart' if apart > 0.3 else None

    # -- internal ---------------------------------------------------------------------------------

    def _master(self) -> str:
        return self.random.choice(('fleet', 'fleet', 'fleet', 'fleet', 'other'))

    def _send(self, sent: Sent) -> str:
        self.sent.append(sent)
        epochs = self.epochs[sent.epoch]
        self.one.handle(replace(sent.order, known_epoch=epochs[0]))
        self.other.receive(replace(sent.order, known_epoch=epochs[1]))
        return str(sent)

    def _walk(self, begin: Tuple[int, ...]) -> Tuple[int, ...]:
        """Returns edges that follow the last edge of `begin`, or the place of the AGVs."""
        drive = self.one.drive
        walk: List[int] = []
        if begin:
            at = GRAPH.end_vertex(begin[-1]).id
        elif drive.vertex is not None:
            at = drive.vertex
        else:
            walk = [self.random.choice((drive.edge, drive.edge, -drive.edge))]
            at = GRAPH.end_vertex(walk[0]).id
        for _ in range(self.random.randint(1, 2)):
            walk.append(self.random.choice(GRAPH.edges_from(at)))
            at = GRAPH.end_vertex(walk[-1]).id
        return tuple(walk)

    def _advance(self, seconds: float) -> None:
        self.time += seconds
        self.one.advance(seconds, 0)
        self.other.drive(seconds)

    def _until(self, one: Callable[[], bool], other: Callable[[], bool]) -> None:
        """Lets each AGV drive until its condition holds."""
        for _ in range(2000):
            done = one(), other()
            if all(done):
                return
            self.time += TICK
            if not done[0]:
                self.one.advance(TICK, 0)
            if not done[1]:
                self.other.drive(TICK)
        raise AssertionError(f'it does not happen: {self.one.state}, {self.other}')


def first_difference(seed: int, plain: Type[Agv] = Agv) -> Optional[str]:
    """Lets random events happen until the AGVs differ; returns the difference and the events."""
    pair, way = Pair(Random(seed), plain), []
    differs = pair.difference()
    for _ in range(EVENTS):
        if differs:
            return '\n'.join((f'seed {seed}: {differs}', *way, str(pair.one.state),
                              str(pair.other)))
        way.append(pair.happens())
        differs = pair.difference()
    return None


@given(st.integers(0, 2 ** 32))
@example(3123269011)  # a route of another master replaces a waiting route
def test_both_take_refuse_and_drive_the_same_orders(seed: int) -> None:
    assert first_difference(seed) is None, first_difference(seed)


class RepeatsNumbers(Agv):
    """An AGV whose reports sometimes have the number of the report before."""

    def told(self, stamp: int) -> RouteReport:
        said = super().told(stamp)
        if said.number % 7 == 0:
            self.knows['report'] -= 1
        return said


class ObeysOlderOrders(Agv):
    """An AGV that takes an order although it has already taken a newer one."""

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        if order.order and order.order < self.knows['taken']:
            self.knows['taken'] = order.order - 1
        return super().receive(order)


class ForgetsRefusals(Agv):
    """An AGV that takes an order although it has already refused a newer one."""

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        if order.order:
            self.knows['refused'] = 0
        return super().receive(order)


class ObeysOtherEpochs(Agv):
    """An AGV that takes orders that were decided in another epoch."""

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        return super().receive(replace(order, known_epoch=self.knows['epoch']))


class KeepsItsEpoch(Agv):
    """An AGV for which an order of another master begins no new epoch."""

    def receive(self, order: RouteOrder) -> Optional[RouteRefusal]:
        if order.order and self.knows['master'] is not None:
            self.knows['master'] = order.master
        return super().receive(order)


class RollsNot(Agv):
    """An AGV that stops dead when it loses its route."""

    def drive(self, seconds: float) -> None:
        self._rolls = 0.0
        super().drive(seconds)


@pytest.mark.parametrize('plain', [RepeatsNumbers, ObeysOlderOrders, ForgetsRefusals,
                                   ObeysOtherEpochs, KeepsItsEpoch, RollsNot])
def test_an_agv_that_breaks_a_rule_is_found(plain: Type[Agv]) -> None:
    assert any(first_difference(seed, plain) for seed in range(100)), plain.__doc__
