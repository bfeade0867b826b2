"""A model of the route driver and a robot; a search visits all states that they can reach.

Both ends are real code: `RouteDriver`, and `route_protocol.vehicle` with a robot on a line. The
network between them is as bad as possible: each order and each report that was ever sent may arrive
at any time, any number of times, or never. Both ends may restart at any time, with or without
their memory; the adapter may even restart with an older journal. Other givers, other masters,
refusals and failures may come at any time.

    places  0 --1-- 1 --2-- 2 --3-- 3 --4-- 4      edges 1 to 4 lead from one vertex to the next

The desk is the part of the vehicle that decides when the driver drives, halts and forgives.
"""
from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Deque, Dict, FrozenSet, Iterator, List, NamedTuple, Optional, Tuple

from route_protocol import vehicle as protocol
from route_protocol.master import REPEAT, Order
from route_protocol.messages import WrongReport
from route_protocol.values import (
    TAKEN_OVER,
    EpochCause,
    Motion,
    Reason,
    ReasonCode,
    RouteOrder,
    RouteReport,
    SymbolicPose,
    VehicleLocation,
)
from route_protocol.vehicle import Answer, VehicleState
from trajectory_graph import Edge, Graph, Vertex
from vda5050_vehicle.drivers.driver import Leg
from vda5050_vehicle.drivers.order_fields import Abilities
from vda5050_vehicle.drivers.order_graph import Matching
from vda5050_vehicle.drivers.robot_view import RobotPose, RobotSnapshot
from vda5050_vehicle.drivers.route_driver import ME, PATIENCE, RouteDrive, RouteDriver

LAST = 4       # the last vertex
LENGTH = 10.0  # m
ANOTHER = 'another'
_FAILED = Reason(ReasonCode.NO_PROGRESS, 'no progress')
_REFUSED = Reason(ReasonCode.OTHER, 'no')


@lru_cache(maxsize=None)
def line() -> Graph:
    """Returns the graph of all places."""
    return Graph([Vertex(k + 1, LENGTH * k, 0.0, 0.0) for k in range(LAST + 1)],
                 [Edge(k, k, k + 1, velocity_forward=1.0, velocity_backwards=1.0)
                  for k in range(1, LAST + 1)])


class Robot(NamedTuple):
    """The robot: its end of the protocol, and its place.

    place  -- 2 k: at vertex k; 2 k + 1: on the edge from vertex k to vertex k + 1
    rolls  -- edges along which the robot may still roll, beginning with the edge under way
    moved  -- another giver moves it
    """

    state: VehicleState
    place: int = 0
    rolls: Tuple[int, ...] = ()
    moved: bool = False

    @property
    def motion(self) -> Motion:
        """The motion that the robot reports."""
        if self.state.is_running:
            return Motion.ON_ROUTE
        if self.moved:
            return Motion.MOVED
        return Motion.COMING_TO_REST if self.rolls else Motion.STANDING

    @property
    def is_ours(self) -> bool:
        """Whether the robot drives for the adapter."""
        return self.state.is_running and self.state.master == ME

    @property
    def pose(self) -> SymbolicPose:
        """The robot's place on the graph; a vertex is the end of the edge that leads to it."""
        if self.place % 2:
            return SymbolicPose(self.place // 2 + 1, 50.0)
        return SymbolicPose(self.place // 2, 100.0) if self.place else SymbolicPose(1, 0.0)


class Desk(NamedTuple):
    """The VDA order under way, as the adapter knows it.

    name     -- number of the order; 0: no order yet
    start    -- the vertex before the first edge of the order
    released -- number of released edges
    passed   -- number of driven edges
    """

    name: int = 0
    start: int = 0
    released: int = 0
    passed: int = 0
    cancels: bool = False
    held: bool = False
    epoch: int = 0

    @property
    def is_busy(self) -> bool:
        """Whether anything is left to do."""
        return self.passed < self.released or self.cancels

    def leg(self, number: int) -> Optional[Leg]:
        """Returns the leg of this number if it is released and not driven; see `DriverMemory`."""
        if not self.passed <= number < self.released:
            return None
        edge = self.start + number + 1
        return Leg(edge, LENGTH, LENGTH * edge, 0.0)


class World(NamedTuple):
    """One state of the model.

    drive, desk  -- the adapter's memory
    heard        -- whether the robot has reported since the adapter started
    older        -- an older journal with which the adapter may restart
    orders       -- all orders that were sent, each with its VDA order; each may arrive at any time
    reports      -- all reports that were sent; each may arrive at any time
    drawn        -- the highest number of an order, of an epoch and of a report
    over         -- names of VDA orders whose cancellation is FINISHED
    overruled    -- during an order of the adapter, a person or another program stopped or drove the
                    robot, and the VDA master has not decided yet
    left         -- how often each event may still happen
    """

    drive: RouteDrive
    desk: Desk
    heard: bool
    older: Tuple[RouteDrive, Desk]
    robot: Robot
    orders: FrozenSet[Tuple[Order, int]]
    reports: FrozenSet[RouteReport]
    drawn: Tuple[int, int, int]
    over: FrozenSet[int]
    overruled: bool
    left: Tuple[Tuple[str, int], ...]

    def may(self, what: str) -> bool:
        """Returns whether this event may still happen."""
        return dict(self.left).get(what, 0) > 0

    def less(self, what: str) -> World:
        """Returns the state in which this event may happen one time less."""
        return self._replace(left=tuple((name, number - (name == what))
                                        for name, number in self.left))


class Flaw(Exception):
    """A property that does not hold."""


class _Memory:
    """The memory of the driver."""

    def __init__(self) -> None:
        self.drive = RouteDrive()
        self.desk = Desk()

    def leg(self, number: int) -> Optional[Leg]:
        """Returns the leg of this number if it is released and not driven; see `DriverMemory`."""
        return self.desk.leg(number)


@dataclass
class Found:
    """The result of a search."""

    states: int
    flaw: str = ''
    path: Tuple[str, ...] = ()

    def __str__(self) -> str:
        return '\n'.join([self.flaw, *self.path])


class RouteWorld:
    """Makes the states that follow a state; `driver` is the class of the driver."""

    def __init__(self, driver: type = RouteDriver) -> None:
        self._memory = _Memory()
        self._clock = 0
        abilities = Abilities(map_id='', corridor=0.45, passing=0.3)
        self._driver: RouteDriver = driver(self._memory, line(), abilities, Matching(),
                                           lambda: self._clock)
        self._kind = driver
        self._sent: Tuple[Order, ...] = ()

    def first(self, bounds: Dict[str, int], is_new: bool = False) -> World:
        """Returns the first state of a search.

        Either the robot has taken a stop of the adapter, or (`is_new`) both ends are new.
        """
        drive = self._new_memory(1)
        left = tuple(sorted(bounds.items()))
        world = World(drive, Desk(), False, (drive, Desk()), Robot(VehicleState(1)), frozenset(),
                      frozenset(), (0, 1, 0), frozenset(), False, left)
        if is_new:
            return world
        world = self._benign_round(world)
        self._load(world).stop(0.0)
        world = self._benign_round(self._settled(world))
        return world._replace(older=(world.drive, world.desk), reports=frozenset())

    def _new_memory(self, clock: int) -> RouteDrive:
        memory, self._clock = _Memory(), clock
        self._kind(memory, line(), self._driver._abilities, Matching(), lambda: clock)
        return memory.drive

    # --- the adapter ------------------------------------------------------------------------------

    def _load(self, world: World) -> RouteDriver:
        driver = self._driver
        self._memory.drive, self._memory.desk = world.drive, world.desk
        self._clock = world.drawn[0] + 1
        driver._is_heard = world.heard
        driver._given_at = driver._sent_at = 0.0
        pose = RobotPose(LENGTH * world.robot.place / 2.0, 0.0, 0.0)
        driver.robot_seen(RobotSnapshot(pose=pose), 0.0)
        return driver

    def _settled(self, world: World) -> World:
        """Returns the state after the steps that follow each event (see `core.vehicle`)."""
        driver, memory = self._driver, self._memory
        desk, over = memory.desk, world.over
        desk = desk._replace(passed=max(desk.passed, min(memory.drive.passed, desk.released)))
        drive = memory.drive
        held = desk.held or bool(drive.failure) and not desk.cancels
        if drive.epoch != desk.epoch:
            held = held or bool(desk.epoch) and desk.is_busy and drive.at_rest and not desk.cancels
            desk = desk._replace(epoch=drive.epoch)
        desk = desk._replace(held=held)
        if desk.cancels and drive.at_rest and drive.stands:
            over = over | {desk.name}
            desk = desk._replace(cancels=False, held=False, released=desk.passed)
            driver.forgive()
        memory.desk = desk
        if desk.cancels or desk.held:
            driver.halt(0.0)
        elif desk.is_busy:
            legs = [desk.leg(number) for number in range(desk.passed, desk.released)]
            driver.drive(desk.passed, [leg for leg in legs if leg], 0.0)
        known, drawn = {order for order, _ in world.orders}, world.drawn[0]
        self._sent = driver.pop_commands()
        new = [order for order in self._sent if order not in known]
        for order in new:
            if order is None or order.number <= world.drawn[0]:
                raise Flaw('a number was drawn again')
            drawn = max(drawn, order.number)
        return world._replace(
            drive=memory.drive, desk=memory.desk, heard=driver._is_heard, over=over,
            orders=world.orders.union((order, desk.name) for order in new),
            drawn=(drawn, *world.drawn[1:]))

    def _adapter(self, world: World) -> Iterator[Tuple[str, World]]:
        for report in world.reports:
            self._load(world).on_report(report, 0.0)
            yield f'report {report.number} arrives', self._settled(world)
        self._load(world).tick(REPEAT)
        yield 'the adapter repeats', self._settled(world)
        if world.may('silence'):
            self._load(world).tick(PATIENCE + 1.0)
            yield 'the adapter gives up', self._settled(world.less('silence'))
        if world.may('order') and not world.desk.is_busy and world.heard:
            yield from self._new_order(world)
        if world.may('update') and world.desk.name and not world.desk.cancels and (
                world.desk.name not in world.over) and (
                world.desk.start + world.desk.released < LAST):
            self._load(world)
            self._memory.desk = world.desk._replace(released=world.desk.released + 1)
            yield 'the base grows', self._settled(world.less('update'))
        if world.may('cancel') and world.desk.is_busy and not world.desk.cancels:
            yield 'cancelOrder', self.cancelled(world.less('cancel'))
        if world.desk.held and world.may('stopPause'):
            driver = self._load(world)
            driver.forgive()
            self._memory.desk = world.desk._replace(held=False)
            yield 'stopPause', self._settled(world.less('stopPause')._replace(overruled=False))
        if world.may('restart'):
            again = world.less('restart')
            yield 'the adapter restarts', self._restarted(again, world.drive, world.desk)
            yield 'the adapter loses its journal', self._restarted(
                again, self._new_memory(world.drawn[0] + 1), Desk())
            yield 'the adapter has an older journal', self._restarted(again, *world.older, False)
        if world.may('journal') and world.older != (world.drive, world.desk):
            yield 'the journal is written', world.less('journal')._replace(
                older=(world.drive, world.desk))

    def _new_order(self, world: World) -> Iterator[Tuple[str, World]]:
        """Yields the state after a new VDA order that begins where the robot is.

        The robot may be in the middle of an edge.
        """
        start = world.robot.place // 2
        if start < LAST:
            yield 'order', self.ordered(world.less('order'), start)

    def ordered(self, world: World, start: int) -> World:
        """Returns the state after a VDA order of one edge."""
        driver = self._load(world)
        name = 1 + max([world.desk.name, *world.over, *(name for _, name in world.orders)])
        self._memory.desk = Desk(name, start, 1, epoch=world.desk.epoch)
        driver.forgive()
        driver.begin()
        return self._settled(world._replace(overruled=False))

    def cancelled(self, world: World) -> World:
        """Returns the state after cancelOrder."""
        driver, drive = self._load(world), world.drive
        self._memory.desk = world.desk._replace(cancels=True)
        if not (drive.in_order and drive.stands):
            driver.stop(0.0)
        return self._settled(world)

    def _restarted(self, world: World, drive: RouteDrive, desk: Desk,
                   is_newest: bool = True) -> World:
        driver = self._load(world._replace(drive=drive, desk=desk, heard=False))
        driver.restart(0.0)
        if desk.is_busy and not is_newest:  # as `core.vehicle` does
            driver.stop(0.0)
            self._memory.desk = desk._replace(held=True)
        return self._settled(world)

    # --- the robot --------------------------------------------------------------------------------

    def _robot(self, world: World) -> Iterator[Tuple[str, World]]:
        robot = world.robot
        if world.may('report'):
            yield 'the robot reports', self.reported(world.less('report'))
        for order, _name in world.orders:
            yield f'order {order.number} arrives', self.arrived(world, order)
            if order.edges and world.may('refusal'):
                yield f'order {order.number} is refused', self.arrived(
                    world.less('refusal'), order, _REFUSED)
        if robot.state.is_running:
            yield 'the robot drives', self.driven(world)
        if robot.rolls:
            yield 'the robot rolls on', world._replace(robot=_rolled(robot))
            yield 'the robot comes to rest', world._replace(robot=robot._replace(rolls=()))
        if robot.moved:
            yield 'the other giver lets it go', world._replace(robot=robot._replace(moved=False))
        if robot.state.is_running and world.may('failure'):
            end = self._end(world)
            end.fail(_FAILED)
            yield 'the route fails', self._after(world.less('failure'), end)
        if world.may('other'):
            yield from self._others(world.less('other'))
        if world.may('reboot'):
            yield from self._reboots(world.less('reboot'))

    def _end(self, world: World) -> protocol.Vehicle:
        _, epochs, reports = world.drawn
        return protocol.Vehicle(lambda: epochs + 1, lambda: reports + 1, world.robot.state)

    def _after(self, world: World, end: protocol.Vehicle, **changes: object) -> World:
        """Returns the state after a change of the robot's end of the protocol.

        A robot that lost its route may roll on.
        """
        robot, orders, epochs, reports = (world.robot, *world.drawn)
        rolls = robot.rolls
        if robot.state.is_running and not end.state.is_running:
            rolls = robot.state.ahead[:2] if robot.place % 2 else ()
        robot = robot._replace(state=end.state, rolls=rolls)._replace(**changes)
        return world._replace(robot=robot, drawn=(
            orders, max(epochs, end.state.epoch), max(reports, end.state.report)))

    def reported(self, world: World) -> World:
        """Returns the state after the robot has reported."""
        robot, end = world.robot, self._end(world)
        report = end.report(0, robot.pose, VehicleLocation(LENGTH * robot.place / 2.0, 0.0, 0.0),
                            robot.motion)
        return self._after(world._replace(reports=world.reports | {report}), end)

    def arrived(self, world: World, order: Order, refusal: Optional[Reason] = None,
                master: str = ME) -> World:
        """Returns the state after an order has arrived at the robot."""
        end, robot, given = self._end(world), world.robot, order.sent_by(master)
        judgement = end.judge(given)
        if judgement.answer is Answer.STOP:
            end.stop(given)
            return self._after(world, end, moved=False)
        if judgement.answer is Answer.REFUSED:
            end.refuse(given, judgement.reason)
        elif judgement.answer is Answer.ROUTE:
            refusal = refusal or _why_not(robot, judgement.rest)
            if not refusal and robot.rolls:
                return world  # the order waits until the robot stands
            if refusal:
                end.refuse(given, refusal)
            else:
                end.take_order(given, judgement.done)
        return self._after(world, end)

    def driven(self, world: World) -> World:
        """Returns the state after the robot has driven half an edge."""
        robot, end = world.robot, self._end(world)
        edge = robot.state.ahead[0]
        if robot.place % 2:
            end.complete(robot.state.completed + 1)
            return self._after(world, end, place=_end_of(edge))
        if robot.is_ours:
            self._check_entry(world, edge)
        return world._replace(robot=robot._replace(place=2 * abs(edge) - 1))

    def _check_entry(self, world: World, edge: int) -> None:
        """Raises Flaw if the order that the robot drives must not lead it onto this edge."""
        number = world.robot.state.order
        name = next(name for order, name in world.orders if order.number == number)
        if name in world.over:
            raise Flaw(f'the robot enters edge {edge} for VDA order {name}, whose cancellation '
                       'was FINISHED')
        if world.overruled:
            raise Flaw(f'the robot enters edge {edge} after another one stopped or drove it')
        desk = world.desk
        if name == desk.name and edge > 0 and not (
                desk.start < edge <= desk.start + desk.released):
            raise Flaw(f'the robot enters edge {edge}, which is not released')

    def _others(self, world: World) -> Iterator[Tuple[str, World]]:
        robot, end = world.robot, self._end(world)
        overruled = world.overruled or robot.is_ours
        end.begin_epoch(EpochCause.OTHER_GIVER, TAKEN_OVER)
        place = (robot.place // 2 - 1) * 2 if robot.place > 1 else 2
        yield 'another giver drives it', self._after(
            world._replace(overruled=overruled), end, place=place, rolls=(), moved=True)
        end = self._end(world)
        end.begin_epoch(EpochCause.STOP, TAKEN_OVER)
        yield 'a person stops it', self._after(world._replace(overruled=overruled), end)
        end = self._end(world)
        end.stop(RouteOrder(0, (), order=1, master=ANOTHER))
        yield 'another master stops it', self._after(world._replace(overruled=overruled), end)

    def _reboots(self, world: World) -> Iterator[Tuple[str, World]]:
        end = self._end(world)
        end.resume(replace(end.state, report=world.drawn[2]))
        yield 'the bridge restarts', world
        end = self._end(world)
        _, epochs, reports = world.drawn
        fresh = protocol.Vehicle(lambda: epochs + 1, lambda: reports + 1)
        yield 'the bridge forgets', self._after(world, fresh, moved=False)
        end.begin_epoch(EpochCause.LOST_LINK)
        yield 'the bridge loses its link', self._after(world, end)

    # --- the search -------------------------------------------------------------------------------

    def following(self, world: World) -> Iterator[Tuple[str, World]]:
        """Yields all states that follow this one."""
        yield from self._adapter(world)
        yield from self._robot(world)

    def search(self, bounds: Dict[str, int], live: bool = False, is_new: bool = False,
               most: int = 10 ** 7) -> Found:
        """Visits all states within the bounds, until a property does not hold.

        live -- whether to check that the robot can be brought to rest and to a new node from each
                state
        """
        first = self.first(bounds, is_new)
        before: Dict[World, Tuple[Optional[World], str]] = {first: (None, '')}
        waiting: Deque[World] = deque([first])
        world = first
        try:
            while waiting and len(before) < most:
                world = waiting.popleft()
                if live:
                    self.bring_to_rest(world)
                    self.bring_to_a_new_node(world)
                for name, after in self.following(world):
                    if after not in before:
                        before[after] = (world, name)
                        waiting.append(after)
        except (Flaw, WrongReport) as flaw:
            return Found(len(before), str(flaw) or type(flaw).__name__, _path(before, world))
        return Found(len(before))

    def bring_to_rest(self, world: World) -> None:
        """Checks that a robot gets a stop if it must not drive on and the network works."""
        for _ in range(3):
            if not (world.desk.held or world.desk.cancels):
                return
            world = self._benign_round(world, drives=False)
        if world.robot.is_ours or world.desk.cancels:
            raise Flaw('the robot does not get the stop')

    def bring_to_a_new_node(self, world: World) -> None:
        """Checks that the robot drives a new order when network, robot and master work."""
        names = {world.desk.name, *world.over, *(name for _, name in world.orders)}
        for _ in range(12):
            world = self._benign_round(world)
            desk, robot = world.desk, world.robot
            if desk.name not in names and desk.passed and not robot.state.is_running:
                return
            if desk.name not in names:
                if desk.held:
                    raise Flaw(f'the new order is held: {world.drive.failure}')
            elif desk.is_busy:
                if not desk.cancels:
                    world = self.cancelled(world)
            elif robot.motion is Motion.STANDING and robot.place % 2 == 0:
                if robot.place == 2 * LAST:
                    return  # the line ends here
                world = self.ordered(world, robot.place // 2)
            else:
                world = world._replace(robot=robot._replace(place=(robot.place // 2 + 1) * 2))
        raise Flaw('the robot cannot be brought to a new node')

    def _benign_round(self, world: World, drives: bool = True) -> World:
        self._load(world).tick(REPEAT)
        world = self._settled(world)
        for order in self._sent:
            world = self.arrived(world, order)
        while world.robot.state.is_running and drives:
            world = self.driven(world)
        world = world._replace(robot=world.robot._replace(rolls=(), moved=False))
        world = self.reported(world)
        self._load(world).on_report(max(world.reports, key=lambda said: said.number), 0.0)
        return self._settled(world)


def _end_of(edge: int) -> int:
    """Returns the place at the end of an edge."""
    return 2 * edge if edge > 0 else 2 * (-edge - 1)


def _why_not(robot: Robot, rest: Tuple[int, ...]) -> Optional[Reason]:
    """Returns the reason why the robot cannot drive these edges; None: it can."""
    if robot.moved:
        return TAKEN_OVER
    starts = {2 * abs(rest[0]) - 1, _end_of(-rest[0])} if rest else {robot.place}
    return None if robot.place in starts else Reason(ReasonCode.STARTS_ELSEWHERE, 'not there')


def _rolled(robot: Robot) -> Robot:
    """Returns the robot after it has rolled on by half an edge."""
    edge = robot.rolls[0]
    if robot.place % 2:
        return robot._replace(place=_end_of(edge), rolls=robot.rolls[1:])
    return robot._replace(place=2 * abs(edge) - 1)


def _path(before: Dict[World, Tuple[Optional[World], str]], world: World) -> Tuple[str, ...]:
    names: List[str] = []
    here: Optional[World] = world
    while here is not None:
        here, name = before[here]
        names.append(name)
    return tuple(reversed(names[:-1]))


