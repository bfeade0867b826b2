"""A VDA 5050 vehicle in virtual time: bench, adapter, bridge, controller and a simulated LD-90.

All of them are the real cores. There is no ROS, broker or socket; each message takes a given time.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, List, Mapping, Sequence, Tuple

import yaml
from bridge_builders import NANOSECONDS
from delayed_drive import DelayedDrive
from modelled_controller import Delays
from simulated_robot import SimulatedRobot

from omron_arcl import ArclError, Execution, Giver, Outcome, Result
from omron_arcl.records import MotionState, RobotMotion
from omron_ld90.bridge import events as p
from route_protocol.values import RouteReport
from trajectory_graph import Graph
from vda5050_bench.master import BenchMaster
from vda5050_mqtt.link import Broker
from vda5050_protocol.codecs import VERSION_2_1
from vda5050_protocol.fields import write_json
from vda5050_protocol.headers import Headers
from vda5050_protocol.values import ConnectionMessage, ConnectionState, Velocity
from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core import factsheet as sheet
from vda5050_vehicle.core.action_table import ActionTable, read_table
from vda5050_vehicle.core.identity import Identity
from vda5050_vehicle.core.vehicle import VdaVehicle
from vda5050_vehicle.drivers.order_graph import Matching
from vda5050_vehicle.drivers.robot_view import RobotPose, RobotSnapshot
from vda5050_vehicle.drivers.route_driver import ME, RouteDriver

FILES = Path(__file__).resolve().parents[3] / 'vda5050_vehicle' / 'config' / 'ld90'
IDENTITY = Identity('OMRON', 'lab', 'map', '1')
ADAPTER = Giver(f'/lab/{ME}', 'process 1')
EPOCH = 1_700_000_000.0  # s; the wall clock at the start
RUNNING, IDLE = 0.1, 1.0  # s between two reports of the bridge
ON_THE_WAY = 0.005  # s, the least delay of a message
_STANDING = (MotionState.STANDING, MotionState.DOCKED)


@lru_cache(maxsize=None)
def _file(name: str) -> Mapping[str, Any]:
    return yaml.safe_load((FILES / name).read_text())


@dataclass(frozen=True)
class VdaDelays(Delays):
    """Delays (s) of messages: those of the base class, and those to and from the adapter."""

    orders: float = 0.0   # adapter -> bridge
    reports: float = 0.0  # bridge -> adapter
    goals: float = 0.0    # adapter -> controller: actions and their cancellations
    results: float = 0.0  # controller -> adapter: ends of actions
    signals: float = 0.0  # controller -> adapter: `motion`
    poses: float = 0.0    # robot -> adapter


class VdaStack(DelayedDrive):
    """An adapter and the bridge that drives its vehicle; `master` gets the adapter's messages."""

    delays: VdaDelays

    def __init__(self, graph: Graph, vertex: int, delays: VdaDelays) -> None:
        abilities = sheet.abilities(_file('vehicle.yaml'), IDENTITY.map_id, ())
        self._vehicle = VdaVehicle(
            IDENTITY, VERSION_2_1, ActionTable(read_table(_file('actions.yaml'))),
            lambda memory: RouteDriver(memory, graph, abilities, Matching(), self._milliseconds),
            abilities)
        self._headers = Headers('2.1.0', IDENTITY.manufacturer, IDENTITY.serial_number,
                                lambda: EPOCH + self.now)
        self._factsheet = sheet.factsheet(_file('vehicle.yaml'), self._vehicle.context.table,
                                          self._vehicle.driver.longest)
        self._goals: Dict[str, Execution] = {}
        self._robot = RobotSnapshot()
        self._reported = -math.inf
        self.notes: List[str] = []
        self.master = VirtualMaster(self)
        super().__init__(graph, vertex, 'rolling', delays, '', 0.0)
        self._time.every(RUNNING, self._take_turn)
        self.later(0.0, self._come_online)

    def make_robot(self, vertex: int, interruption: str, braking: float) -> SimulatedRobot:
        """See DelayedDrive."""
        return SimulatedRobot(vertex, self._say, lambda: self.now, 'interrupted name')

    def _milliseconds(self) -> int:
        return int(1000.0 * (EPOCH + self.now))

    # --- the bridge -------------------------------------------------------------------------------

    def _act(self, actions: Sequence[p.Action]) -> None:
        super()._act(actions)
        for action in actions:
            if isinstance(action, RouteReport):
                self._report(action)
            elif isinstance(action, p.BridgeNote):
                self.notes.append(action.text)

    def _report(self, report: RouteReport) -> None:
        self.later(self.delays.reports, lambda: self._hear_report(report))

    def _hear_report(self, report: RouteReport) -> None:
        self._vehicle.driver.on_report(report, self.now)
        self._perform(self._vehicle.tick(self.now))

    # --- the adapter's periodic work, and what it learns about the robot --------------------------

    def _take_turn(self) -> None:
        assert self.bridge
        if self.now - self._reported >= (RUNNING if self.bridge.running else IDLE) - 0.05:
            self._reported = self.now
            self._report(self.bridge.report())
        self._perform(self._vehicle.robot_seen(self._robot, self.now))
        self._perform(self._vehicle.tick(self.now))

    def _on_motion(self, motion: RobotMotion) -> None:
        super()._on_motion(motion)
        standing = None if motion.state is MotionState.UNKNOWN else motion.state in _STANDING
        self.later(self.delays.signals, lambda: self._see(
            standing=standing, epoch=motion.memory.epoch))

    def _show_status(self) -> None:
        super()._show_status()
        pose, now = RobotPose(*self.robot.position, 0.0), self.now
        self.later(self.delays.poses, lambda: self._see(pose=pose, seen_at=now))

    def _see(self, **values: Any) -> None:
        before, told = self._robot.pose, {**vars(self._robot), **values}
        if 'pose' in values and before is not None:
            moved = math.dist((before.x, before.y), (told['pose'].x, told['pose'].y))
            told['velocity'] = Velocity(moved / self.robot_period, 0.0, 0.0)
        self._robot = RobotSnapshot(**told)
        self._perform(self._vehicle.robot_seen(self._robot, self.now))

    @property
    def robot_period(self) -> float:
        """Seconds between two statuses of the robot."""
        return 0.5

    # --- what the adapter does --------------------------------------------------------------------

    def receive(self, topic: str, payload: bytes) -> None:
        """Delivers a message of the master to the adapter."""
        self._perform(self._vehicle.receive([(topic, payload)], self.now))

    def _come_online(self) -> None:
        self._send('connection', ConnectionMessage(ConnectionState('ONLINE')))
        self._perform(self._vehicle.connected(self.now))

    def _perform(self, effects: Tuple[fx.Effect, ...]) -> None:
        for effect in effects:
            if isinstance(effect, fx.SendState):
                self._send('state', effect.state)
            elif isinstance(effect, fx.SendFactsheet):
                self._send('factsheet', self._factsheet)
            elif isinstance(effect, fx.DriverCommand):
                order = effect.command.sent_by(ME, int((EPOCH + self.now) * NANOSECONDS))
                self.later(self.delays.orders, lambda order=order: self._tell(order))
            elif isinstance(effect, fx.StartAction):
                self.later(self.delays.goals, lambda effect=effect: self._start(effect))
            elif isinstance(effect, fx.CancelAction):
                self.later(self.delays.goals, lambda name=effect.action_id: self._cancel(name))

    def _start(self, action: fx.StartAction) -> None:
        assert action.spec.call
        command = action.spec.call.fields(action.arguments)['command']

        def end(result: Result) -> None:
            self.later(self.delays.results, lambda: self._perform(self._vehicle.action_ended(
                action.action_id, result.outcome is Outcome.SUCCEEDED, result.words, self.now)))
        try:
            self._goals[action.action_id] = self._controller.give(command, ADAPTER, 0, end)
        except ArclError as error:
            self._perform(self._vehicle.action_ended(action.action_id, False, str(error), self.now))

    def _cancel(self, name: str) -> None:
        if self._goals[name].result is None:
            self._controller.cancel_own(self._goals[name])

    def _send(self, topic: str, message: Any) -> None:
        payload = write_json(VERSION_2_1.write(topic, self._headers.make(topic), message))
        self.later(ON_THE_WAY, lambda: self.master.receive(topic, payload))


class VirtualMaster(BenchMaster):
    """The bench's master, without a broker, with the clock of a stack."""

    def __init__(self, stack: VdaStack) -> None:
        self._stack = stack
        super().__init__(Broker('nowhere', 0), 'uagv/v2/OMRON/lab')

    def _connect(self, broker: Broker) -> None:
        """Does nothing: there is no broker."""

    def _publish(self, topic: str, payload: bytes) -> None:
        self._stack.later(ON_THE_WAY, lambda: self._stack.receive(topic, payload))

    def now(self) -> float:
        """See BenchMaster."""
        return self._stack.now

    def rest(self, seconds: float) -> None:
        """See BenchMaster."""
        before = sum(map(len, self.messages.values()))
        self._stack.run(seconds, lambda: sum(map(len, self.messages.values())) > before)

    def is_retained(self, topic: str) -> bool:
        """See BenchMaster."""
        return True
