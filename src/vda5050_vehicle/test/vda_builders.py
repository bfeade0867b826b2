"""Common parts of the tests: a laboratory vehicle, the robot's side of the protocol, orders."""
from __future__ import annotations

import json
from dataclasses import replace
from functools import lru_cache
from itertools import count
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import yaml
from vda_messages import ROOT, payload

from route_protocol import vehicle as protocol
from route_protocol.master import Order
from route_protocol.values import (
    NO_REASON,
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
from route_protocol.vehicle import Answer
from trajectory_graph import Graph, load_graph
from vda5050_bench.checker import VehicleChecker
from vda5050_bench.layout import track_on
from vda5050_bench.track import Track, action
from vda5050_bench.version_3 import in_3
from vda5050_protocol.codecs import VERSION_2_1, Codec
from vda5050_protocol.fields import write_json
from vda5050_protocol.headers import Headers
from vda5050_protocol.values import BatteryState, Velocity
from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core import factsheet as sheet
from vda5050_vehicle.core import journal
from vda5050_vehicle.core.action_table import ActionTable, read_table
from vda5050_vehicle.core.identity import Identity
from vda5050_vehicle.core.vehicle import MakeDriver, VdaVehicle
from vda5050_vehicle.drivers.driver import SETTLING
from vda5050_vehicle.drivers.order_fields import Abilities
from vda5050_vehicle.drivers.order_graph import Matching
from vda5050_vehicle.drivers.robot_view import RobotPose, RobotSnapshot
from vda5050_vehicle.drivers.route_driver import ME, RouteDriver

PACKAGE = Path(__file__).resolve().parents[1]
IDENTITY = Identity('OMRON', 'lab', 'map', '1')
STANDING, DRIVING = Velocity(0.0, 0.0, 0.0), Velocity(1.0, 0.0, 0.0)
SAY = {'text': 'hello'}
CLOCK = 1_700_000_000_000  # ms since 1970
_EPOCHS, _REPORTS = count(1), count(1)  # numbers that never repeat, not even after restarts


@lru_cache(maxsize=None)
def lab() -> Graph:
    """The example laboratory."""
    return load_graph(ROOT / 'maps' / 'lab_graph.yaml')


@lru_cache(maxsize=None)
def table() -> ActionTable:
    """The LD-90's actions."""
    return ActionTable(read_table(yaml.safe_load(
        (PACKAGE / 'config' / 'ld90' / 'actions.yaml').read_text())))


def vehicle_document() -> Dict[str, Any]:
    """Returns the contents of the LD-90's vehicle file."""
    return yaml.safe_load((PACKAGE / 'config' / 'ld90' / 'vehicle.yaml').read_text())


def abilities(*ignored: str) -> Abilities:
    """Returns the abilities of the LD-90."""
    return sheet.abilities(vehicle_document(), 'map', ignored)


def route_driver(graph: Optional[Graph] = None, *ignored: str) -> MakeDriver:
    """Makes drivers for the laboratory's routes."""
    return lambda memory: RouteDriver(memory, graph or lab(), abilities(*ignored), Matching(),
                                      lambda: CLOCK)


def way(*vertices: int) -> Track:
    """Returns the shortest track over these vertices of the laboratory."""
    return track_on(lab(), vertices, 'map')


class RobotSide:
    """The robot that receives the orders; its end of the route protocol is the real code.

    The robot takes each order that the protocol allows, drives when the test says so, and stops at
    once.
    """

    def __init__(self) -> None:
        self.vehicle = protocol.Vehicle(lambda: next(_EPOCHS), lambda: next(_REPORTS))
        self.percentage = 0.0
        self.place: Optional[SymbolicPose] = None  # where the robot stands, if a test sets this
        self.routes: List[Order] = []  # all orders that were sent to the robot, received or not
        self.answers = True
        self.refuses: Optional[Reason] = None
        self.owes_stop = ''
        self.rolls = False  # the robot has not come to rest yet
        self._driven: Tuple[int, ...] = ()  # edges of the route before the edges of the last order

    def arrive(self, order: Order) -> None:
        """Receives an order."""
        self.routes.append(order)
        if self.answers:
            self.judge(order.sent_by(ME))

    def judge(self, order: RouteOrder) -> None:
        """Answers an order as the protocol says."""
        judgement = self.vehicle.judge(order)
        if judgement.answer is Answer.STOP:
            self.vehicle.stop(order)
            self._driven = ()
        elif judgement.answer is Answer.REFUSED or (
                judgement.answer is Answer.ROUTE and self.refuses):
            self.vehicle.refuse(order, self.refuses or judgement.reason)
        elif judgement.answer is Answer.ROUTE:
            is_same = order.route_id == self.route_id
            self._driven = self.route[:self.done] if is_same else ()
            self._driven = self._driven[:len(self._driven) - (judgement.done - order.first)]
            self.vehicle.take_order(order, judgement.done)
            self.percentage, self.place = (self.percentage if is_same else 0.0), None

    def report(self) -> RouteReport:
        """Returns the present report."""
        return self.vehicle.report(
            0, self.pose, VehicleLocation(0.0, 0.0, 0.0), self.motion,
            Reason(ReasonCode.STOP_OWED, self.owes_stop) if self.owes_stop else NO_REASON)

    @property
    def motion(self) -> Motion:
        """The motion that the robot reports."""
        if self.drives:
            return Motion.ON_ROUTE
        return Motion.COMING_TO_REST if self.owes_stop or self.rolls else Motion.STANDING

    @property
    def pose(self) -> SymbolicPose:
        """The robot's place on its route, or `place`."""
        if self.place is not None or not self.route:
            return self.place or SymbolicPose()
        edge = self.route[min(self.done, len(self.route) - 1)]
        return SymbolicPose(edge, self.percentage if self.done < len(self.route) else 100.0)

    @property
    def route_id(self) -> int:
        """The label of the robot's route."""
        return self.vehicle.state.route_id

    @property
    def route(self) -> Tuple[int, ...]:
        """All edges that the robot drives, or has driven, under the label of its route."""
        return self._driven + self.vehicle.state.edges

    @property
    def done(self) -> int:
        """How many edges of `route` have been driven."""
        return len(self._driven) + self.vehicle.state.completed

    @done.setter
    def done(self, number: int) -> None:
        self.vehicle.complete(number - len(self._driven))

    @property
    def drives(self) -> bool:
        """Whether the robot has edges left to drive."""
        return self.vehicle.state.is_running

    def fail(self, text: str) -> None:
        """Lets the route of the robot fail."""
        self.vehicle.fail(Reason(ReasonCode.OTHER, text))

    def overruled(self, cause: EpochCause = EpochCause.OTHER_GIVER,
                  reason: Reason = TAKEN_OVER) -> None:
        """Begins a new epoch; by default, another giver drives or stops the robot."""
        self.vehicle.begin_epoch(cause, reason)

    def taken_by_another_master(self) -> None:
        """Sends the robot a route of another master."""
        self.judge(RouteOrder(4711, (9,), known_epoch=self.vehicle.state.epoch, order=1,
                              master='another'))


class Lab:
    """A vehicle in the laboratory, with its robot's side, a clock, and all its messages.

    Each state that the vehicle sends must satisfy the rules that a schema cannot express.
    """

    def __init__(self, at: Optional[int] = 8, driver: Optional[MakeDriver] = None,
                 codec: Codec = VERSION_2_1, abilities_: Optional[Abilities] = None) -> None:
        self.now = 100.0
        self.messages = 0  # messages of the master; each has a header of its own
        self.robot = RobotSide()
        can = abilities_ or abilities()
        self.make_driver = driver or (
            lambda memory: RouteDriver(memory, lab(), can, Matching(), lambda: CLOCK))
        self.vehicle = VdaVehicle(IDENTITY, codec, table(), self.make_driver, can)
        self.driver: Any = self.vehicle.driver
        self.codec = codec
        self.states: List[Dict[str, Any]] = []  # in the keys of 2.1
        self.wire: Dict[str, Any] = {}  # the last state as it was sent
        self.started: List[str] = []
        self.cancelled: List[str] = []
        self.effects: List[fx.Effect] = []
        self.journal: List[str] = []
        self.is_seen = True  # the vehicle receives the robot's state all the time
        self.checker = VehicleChecker('OMRON', 'lab', codec.version)
        self.headers = Headers(codec.version, 'OMRON', 'lab', lambda: 1e9 + self.now)
        self.view = RobotSnapshot(velocity=STANDING, battery=BatteryState(80.0, False), lost='')
        self.begin_to_command()
        if at is not None:  # otherwise the robot has not reported yet
            self.stand_at(at)

    def begin_to_command(self) -> None:
        """Makes the robot count the orders of the adapter, as after an earlier order."""
        if isinstance(self.driver, RouteDriver):
            self.driver.stop(self.now)
            for command in self.driver.pop_commands():
                self.robot.arrive(command)
            self.driver.on_report(self.robot.report(), self.now)
            self.robot.routes.clear()

    # --- events -----------------------------------------------------------------------------------

    def stand_at(self, vertex: int) -> None:
        """Reports that the robot stands at a vertex."""
        x, y = lab().vertex(vertex).position
        self.see(pose=RobotPose(x, y, 0.0), velocity=STANDING)

    def see(self, **changes: Any) -> None:
        """Gives the vehicle the robot's state with these changes."""
        self.view = replace(self.view, seen_at=self.now, **changes)
        self.do(self.vehicle.robot_seen(self.view, self.now))

    def order(self, order: Dict[str, Any]) -> bytes:
        """Gives the vehicle an order; returns the message."""
        self.messages += 1
        message = self.payload('order', order)
        self.receive_order(message)
        return message

    def payload(self, topic: str, message: Mapping[str, Any]) -> bytes:
        """Returns a message of 2.1 in the format of this vehicle's version."""
        body = in_3(topic, message) if self.codec.is_3 else message
        return payload(body, self.messages, self.codec.version)

    def receive_order(self, message: bytes) -> None:
        """Gives the vehicle these bytes on the topic `order`."""
        self.do(self.vehicle.receive([('order', message)], self.now))

    def act(self, action_type: str, action_id: str = '', blocking: str = 'NONE',
            **parameters: Any) -> str:
        """Gives the vehicle an instant action; returns its id."""
        action_id = action_id or f'{action_type}-{self.messages}'
        self.messages += 1
        message = {'actions': [action(action_type, action_id, blocking, **parameters)]}
        self.receive_instant_actions(self.payload('instantActions', message))
        return action_id

    def receive_instant_actions(self, message: bytes) -> None:
        """Gives the vehicle these bytes on the topic `instantActions`."""
        self.do(self.vehicle.receive([('instantActions', message)], self.now))

    def wait(self, seconds: float) -> None:
        """Lets time pass; the robot's side reports."""
        for _ in range(max(round(seconds / 0.1), 1)):
            self.now += 0.1
            if isinstance(self.driver, RouteDriver) and self.robot.answers:
                self.driver.on_report(self.robot.report(), self.now)
            self.do(self.vehicle.tick(self.now))
            if self.is_seen:
                self.see()

    def drive(self, edges: int = 1) -> None:
        """Lets the robot drive the given number of edges of its route."""
        for _ in range(edges):
            assert self.robot.drives, 'the robot has no edge left to drive'
            self.see(velocity=DRIVING)
            self.robot.done += 1
            self.robot.percentage = 0.0
            vertex = lab().end_vertex(self.robot.route[self.robot.done - 1])
            self.see(pose=RobotPose(*vertex.position, 0.0))
            self.wait(0.1)
        if not self.robot.drives:
            self.see(velocity=STANDING)

    def settle(self) -> None:
        """Lets the robot obey a stop."""
        self.see(velocity=STANDING)
        self.wait(SETTLING + 0.3)

    def end_action(self, action_id: str, succeeded: bool = True, text: str = '') -> None:
        """Ends a started action."""
        self.do(self.vehicle.action_ended(action_id, succeeded, text, self.now))

    def restarted(self, is_newest: bool = True) -> Lab:
        """Kills the adapter; returns a laboratory whose new adapter starts from the journal."""
        other = type(self).__new__(type(self))
        other.__dict__.update(self.__dict__)
        other.vehicle = VdaVehicle(IDENTITY, self.codec, table(), self.make_driver, abilities())
        other.driver = other.vehicle.driver
        other.started, other.cancelled, other.effects = [], [], []
        other.checker.restarted()
        state = journal.read(self.journal, type(self.vehicle.state.drive))
        other.vehicle.restore(state, is_newest, self.now)
        other.see()
        return other

    def do(self, effects: Sequence[fx.Effect]) -> None:
        """Carries out the effects that the vehicle requests."""
        for effect in effects:
            self.effects.append(effect)
            if isinstance(effect, fx.DriverCommand):
                self.robot.arrive(effect.command)
            elif isinstance(effect, fx.SendState):
                message = write_json(self.codec.write('state', self.headers.make('state'),
                                                      effect.state))
                self.wire = json.loads(message)
                self.states.append(self.checker.feed('state', message))
            elif isinstance(effect, fx.StartAction):
                self.started.append(effect.action_id)
            elif isinstance(effect, fx.CancelAction):
                self.cancelled.append(effect.action_id)
            elif isinstance(effect, fx.Keep):
                self.journal.append(journal.line(effect.before, effect.now))
        assert not self.checker.violations, self.checker.violations

    @property
    def order_record(self) -> Dict[str, Any]:
        """The vehicle's record of its order."""
        state = self.vehicle.state
        return {name: getattr(state, name) for name in (
            'order', 'taken', 'legs', 'actions', 'paused', 'cancels', 'pauses', 'received')}

    # --- messages of the vehicle ------------------------------------------------------------------

    @property
    def state(self) -> Dict[str, Any]:
        """The last state that was sent."""
        return self.states[-1]

    @property
    def nodes(self) -> List[str]:
        """The remaining nodes."""
        return [node['nodeId'] for node in self.state['nodeStates']]

    @property
    def errors(self) -> List[str]:
        """The types of the errors."""
        return [error['errorType'] for error in self.state['errors']]

    def status(self, action_id: str) -> Optional[str]:
        """Returns the last reported status of an action; None: there is none."""
        return next((found['actionStatus'] for found in self.state['actionStates']
                     if found['actionId'] == action_id), None)


def say(action_id: str, blocking: str = 'NONE') -> Dict[str, Any]:
    """Returns an action of the table."""
    return action('say', action_id, blocking, **SAY)
