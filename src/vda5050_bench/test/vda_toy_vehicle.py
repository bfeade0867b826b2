"""A small vehicle for tests of the bench; it can have defects.

Without defects it obeys the standard. It drives on a straight line in simulated time. It shares no
code with the adapter.
"""
from __future__ import annotations

import json
import math
from typing import Any, Callable, Dict, List, Optional, Tuple

from vda5050_bench.master import BenchMaster
from vda5050_bench.track import Stop, Track
from vda5050_mqtt.link import Broker

LINE = Track(tuple(Stop(f'n{i}', 3.0 * i, 0.0) for i in range(4)),
             ('e0', 'e1', 'e2'), ('b0', 'b1', 'b2'), 'hall')
STEP = 0.1
SLOW = 5.0  # s that `blink` takes
QUICK = ('stateRequest', 'factsheetRequest', 'startPause', 'stopPause', 'cancelOrder',
         'clearInstantActions')
_IN_3 = {'validationError': 'VALIDATION_FAILURE', 'orderError': 'INVALID_ORDER',
         'orderUpdateError': 'OUTDATED_ORDER_UPDATE', 'noOrderToCancel': 'NO_ORDER_TO_CANCEL'}

Json = Dict[str, Any]


class Refused(Exception):
    """The refusal of an order: the type and the references of the error."""

    def __init__(self, kind: str, **references: Any) -> None:
        super().__init__(kind)
        self.kind = kind
        self.references = references


class ToyVehicle:
    """The vehicle. It calls `send` with each message. `defects` names its defects; see `wrong`."""

    def __init__(self, *defects: str, version: str = '2.1.0') -> None:
        self.defects = set(defects)
        self.is_3 = version.startswith('3')
        self.version = version
        self.send: Callable[[str, bytes], None] = lambda topic, payload: None
        self.now = 0.0
        self.x, self.theta = 0.0, 0.0
        self.driving = self.paused = self.is_cancelled = self.is_stuck = False
        self.order: Json = {'orderId': '', 'orderUpdateId': 0}
        self.last: Tuple[str, int] = ('n0', 0)
        self.nodes: List[Json] = []
        self.edges: List[Json] = []
        self.actions: Dict[str, Json] = {}
        self.instant: Dict[str, Json] = {}
        self.ends: Dict[str, float] = {}
        self.errors: List[Json] = []
        self.garbage: Json = {}  # in each state
        self._revives_at = 0.0
        self._is_new = False
        self._headers: Dict[str, int] = {}
        self._told = ''
        self._told_at = 0.0

    def wrong(self, defect: str) -> bool:
        """Returns whether the vehicle has this defect."""
        return defect in self.defects

    # --- messages of the vehicle ------------------------------------------------------------------

    def publish(self, topic: str, body: Json) -> None:
        """Publishes a message with the next header of its topic."""
        if self.wrong('silent') and self.now > 60.0 or self.is_dead:
            return
        number = self._headers.get(topic, 0)
        self._headers[topic] = number + 1
        stamp = f'2026-01-01T{int(self.now // 3600):02}:{int(self.now // 60) % 60:02}:' \
                f'{self.now % 60:06.3f}Z'
        self.send(topic, json.dumps({
            'headerId': number, 'timestamp': stamp, 'version': self.version, 'manufacturer': 'Toy',
            'serialNumber': '1', **body, **(self.garbage if topic == 'state' else {})}).encode())

    def tell(self, always: bool = False) -> None:
        """Sends a state if something has changed."""
        told = json.dumps([self.order['orderId'], self.order['orderUpdateId'], self.last,
                           self.nodes, self.errors, self.driving, self.paused,
                           list(self.actions.values()), list(self.instant.values())])
        if always or told != self._told or self.now >= self._told_at + 30.0:
            self._told, self._told_at = told, self.now
            self.publish('state', self._state())

    def _state(self) -> Json:
        theta = self.theta
        if self.wrong('rounds pi'):
            theta = round(theta, 6)
        instant, actions = list(self.instant.values()), list(self.actions.values())
        state: Json = {
            'orderId': self.order['orderId'], 'orderUpdateId': self.order['orderUpdateId'],
            'lastNodeId': self.last[0], 'lastNodeSequenceId': self.last[1],
            'nodeStates': [{key: node[key] for key in ('nodeId', 'sequenceId', 'released')}
                           for node in self.nodes],
            'edgeStates': [{key: edge[key] for key in ('edgeId', 'sequenceId', 'released')}
                           for edge in self.edges],
            'driving': self.driving, 'actionStates': [*actions, *([] if self.is_3 else instant)],
            'paused': self.paused, 'operatingMode': 'AUTOMATIC', 'errors': self.errors}
        pose: Json = {'x': self.x, 'y': 0.0, 'theta': theta, 'mapId': 'hall'}
        battery: Json = {'charging': False}
        if self.wrong('no batteryState'):
            return {**state, 'agvPosition': {**pose, 'positionInitialized': True}}
        if self.is_3:
            return {**state, 'instantActionStates': instant,
                    'mobileRobotPosition': {**pose, 'localized': True},
                    'powerSupply': {**battery, 'stateOfCharge': 80.0},
                    'safetyState': {'activeEmergencyStop': 'NONE', 'fieldViolation': False}}
        return {**state, 'agvPosition': {**pose, 'positionInitialized': True},
                'batteryState': {**battery, 'batteryCharge': 80.0},
                'safetyState': {'eStop': 'NONE', 'fieldViolation': False}}

    def _complain(self, kind: str, is_instant: bool = False, **references: Any) -> None:
        if self.is_3 and not is_instant:
            kind = _IN_3.get(kind, kind)
        self.errors.append({
            'errorType': kind, 'errorLevel': 'WARNING', 'errorReferences': [
                {'referenceKey': key, 'referenceValue': str(value)}
                for key, value in references.items()]})

    # --- death ------------------------------------------------------------------------------------

    @property
    def is_dead(self) -> bool:
        """Whether the vehicle has crashed and has not started again yet."""
        return self.now < self._revives_at

    def publish_will(self) -> None:
        """Publishes the last will in place of the broker."""
        self.send('connection', json.dumps({
            'headerId': 0, 'timestamp': '2026-01-01T00:00:00.000Z', 'version': self.version,
            'manufacturer': 'Toy', 'serialNumber': '1',
            'connectionState': 'CONNECTION_BROKEN' if self.is_3 else 'CONNECTIONBROKEN'}).encode())

    def _starts_again(self) -> bool:
        if not self._revives_at or self._is_new:
            return False
        self._is_new = True
        self._headers = {}
        self.order, self.nodes, self.edges = {'orderId': '', 'orderUpdateId': 0}, [], []
        self.actions, self.instant, self.ends, self.errors = {}, {}, {}, []
        self.publish('connection', {'connectionState': 'ONLINE'})
        self.tell(always=True)
        return True

    # --- messages to the vehicle ------------------------------------------------------------------

    def receive(self, topic: str, payload: bytes) -> None:
        """Receives a message of the master."""
        if self.wrong('silent') and self.now > 60.0 or self.is_dead:
            return
        if topic == 'order':
            self._receive_order(payload)
        else:
            for action in json.loads(payload)['actions']:
                self._act(action)
        self.tell()

    def _receive_order(self, payload: bytes) -> None:
        message: Json = {}
        try:
            message = self._read(payload)
            self._check(message)
            is_update = message['orderId'] == self.order['orderId']
            if is_update and message['orderUpdateId'] == self.order['orderUpdateId']:
                return
            (self._check_update if is_update else self._check_new)(message)
        except Refused as refused:
            self._complain(refused.kind, **({} if self.wrong('no references')
                                            else refused.references))
            return
        self._take(message, is_update)

    def _read(self, payload: bytes) -> Json:
        try:
            message = json.loads(payload.decode())
        except ValueError:
            raise Refused('validationError') from None
        if not isinstance(message, dict):
            raise Refused('validationError')
        return message

    def _check(self, message: Json) -> None:
        ids = {key: message.get(key) for key in ('orderId', 'orderUpdateId')}
        try:
            nodes, edges = message['nodes'], message['edges']
            right = (nodes and len(edges) == len(nodes) - 1
                     and all(isinstance(node['nodeId'], str) and isinstance(node['released'], bool)
                             for node in nodes)
                     and all(action['blockingType'] in ('NONE', 'SOFT', 'HARD')
                             for node in nodes for action in node['actions']))
            elements = sorted([*nodes, *edges], key=lambda element: int(element['sequenceId']))
            ids_of = [element['sequenceId'] for element in elements]
            released = [element['released'] for element in elements]
            right = (right and ids_of == list(range(ids_of[0], ids_of[0] + len(ids_of)))
                     and released == sorted(released, reverse=True)
                     and (self._knows_no_ends or all(
                         edge['endNodeId'] == node['nodeId']
                         for edge, node in zip(edges, nodes[1:]))))
            theta = nodes[0]['nodePosition'].get('theta', 0.0) if nodes else 0.0
        except (AttributeError, IndexError, KeyError, TypeError):
            right, theta = False, 0.0
        if not right or abs(theta) > (3.0 if self.wrong('refuses pi') else math.pi):
            raise Refused('validationError', **ids)
        for node in nodes:
            for action in node['actions']:
                if action['actionType'] != 'blink':
                    raise Refused('orderError', actionId=action['actionId'], **ids)
            for key in ('theta', 'allowedDeviationXY'):
                if key in node['nodePosition'] and not self._can(key, node):
                    raise Refused('orderError', field=key, **ids)

    @property
    def _knows_no_ends(self) -> bool:
        """Whether edges have no ids of their end nodes, as in VDA 5050 3.0, 7.3."""
        return self.is_3 and not self.wrong('wants the ends of edges')

    def _can(self, key: str, node: Json) -> bool:
        if self.wrong('ignores fields'):
            return True
        position = node['nodePosition']
        if key == 'theta':
            return abs(position['theta'] - self.theta) < 1e-5 and node['nodeId'] == self.last[0]
        size = position[key]['a'] if self.is_3 else position[key]
        return bool(size > 0.1)

    @property
    def is_busy(self) -> bool:
        """Whether the answer to question 3 of figure 8 is yes."""
        actions = dict(self.actions) if self.is_3 else {**self.actions, **self.instant}
        if self.wrong('accepts beside actions'):
            actions = {}
        return bool(self.nodes) or any(action['actionStatus'] not in ('FINISHED', 'FAILED')
                                       for action in actions.values())

    def _check_new(self, message: Json) -> None:
        position = message['nodes'][0]['nodePosition']
        allowed = position.get('allowedDeviationXY', 0.3)
        ids = {key: message[key] for key in ('orderId', 'orderUpdateId')}
        if self.is_busy:
            raise Refused('orderError', **ids)
        if self.is_3 and message['orderUpdateId'] and not self.wrong('any first update'):
            raise Refused('INVALID_ORDER', **ids)
        if abs(position['x'] - self.x) > (allowed['a'] if isinstance(allowed, dict) else allowed):
            raise Refused('noRouteError', **ids)

    def _check_update(self, message: Json) -> None:
        first = message['nodes'][0]
        ids = {key: message[key] for key in ('orderId', 'orderUpdateId')}
        if self.wrong('drives every edge') and any(
                node['nodeId'] == other['nodeId']
                for node, other in zip(message['nodes'], message['nodes'][1:])):
            raise Refused('NO_ROUTE_TO_TARGET', **ids)
        if self.is_3 and self.is_cancelled:
            raise Refused('orderError' if self.wrong('other error after cancel')
                          else 'ORDER_UPDATE_FOLLOWING_CANCEL', **ids)
        base = [node for node in self.nodes if node['released']]
        at = (base[-1]['nodeId'], base[-1]['sequenceId']) if base else self.last
        if message['orderUpdateId'] < self.order['orderUpdateId'] \
                or (first['nodeId'], first['sequenceId']) != at:
            raise Refused('orderUpdateError', **ids)

    def _take(self, message: Json, is_update: bool) -> None:
        first = message['nodes'][0]
        if not is_update:
            self.is_stuck = (self.wrong('finds no way to the first node')
                             and first['nodeId'] != self.last[0]
                             and abs(first['nodePosition']['x'] - self.x) > 0.3)
            self.nodes, self.edges, self.actions = [], [], {}
            self.instant = self.instant if self.is_3 else {
                key: value for key, value in self.instant.items() if key in self.ends}
            self.last = (first['nodeId'], first['sequenceId'])
        self.order, self.is_cancelled = message, False
        self.nodes = [node for node in self.nodes if node['released']] + message['nodes'][1:]
        self.edges = [edge for edge in self.edges if edge['released']] + message['edges']
        new = message['nodes'][1:] if is_update else message['nodes']
        for node in new:
            for action in node['actions']:
                self.actions[action['actionId']] = self._action_state(action, 'WAITING')
        self.errors = [error for error in self.errors
                       if error['errorType'] == 'INVALID_INSTANT_ACTION']
        if not is_update and not self.wrong('no actions at the first node'):
            self._begin_actions(first)

    # --- actions ----------------------------------------------------------------------------------

    def _action_state(self, action: Json, status: str) -> Json:
        return {'actionId': action['actionId'], 'actionType': action['actionType'],
                'actionStatus': status}

    def _begin_actions(self, node: Json) -> None:
        for action in node['actions']:
            self.actions[action['actionId']]['actionStatus'] = 'RUNNING'
            self.ends[action['actionId']] = self.now + SLOW

    def _act(self, action: Json) -> None:
        kind, name = action['actionType'], action['actionId']
        known = self.instant[name] = self._action_state(action, 'FINISHED')
        if kind == 'blink':
            known['actionStatus'] = 'RUNNING'
            self.ends[name] = self.now + SLOW
        elif kind == 'cancelOrder' and not (self.nodes or self.is_busy and self.actions):
            known['actionStatus'] = 'FAILED'
            self._complain('noOrderToCancel', actionId=name)
        elif kind == 'cancelOrder':
            self._cancel()
        elif kind == 'startPause' and self.wrong('no pause'):
            known['actionStatus'] = 'FAILED'
        elif kind in ('startPause', 'stopPause'):
            self.paused = kind == 'startPause'
            self.driving = False
        elif kind == 'clearInstantActions' and self.is_3:
            if not self.wrong('clears nothing'):
                self.instant = {name: known}
        elif kind == 'factsheetRequest':
            self.tell_factsheet()
        elif kind == 'stateRequest':
            if not self.wrong('no stateRequest'):
                self.tell(always=True)
        elif kind not in QUICK:
            known['actionStatus'] = 'FAILED'
            if self.is_3:
                self._complain('INVALID_INSTANT_ACTION', True, actionId=name)
        if kind in QUICK and not self.wrong('keeps instant errors'):
            self.errors = [error for error in self.errors
                           if error['errorType'] != 'INVALID_INSTANT_ACTION']

    def tell_factsheet(self) -> None:
        """Sends the factsheet."""
        if not self.wrong('no factsheet'):
            key = 'mobileRobotActions' if self.is_3 else 'agvActions'
            listed = [{'actionType': kind} for kind in (*QUICK, 'blink')]
            self.publish('factsheet', {'protocolFeatures': {key: listed}})

    def _cancel(self) -> None:
        self.is_cancelled = True
        self.driving = self.wrong('drives on')
        if not self.driving:
            self.nodes, self.edges = [], []
        for action in self.actions.values():
            if action['actionStatus'] not in ('FINISHED', 'FAILED'):
                action['actionStatus'] = 'FAILED'
                self.ends.pop(action['actionId'], None)

    # --- time -------------------------------------------------------------------------------------

    def step(self) -> None:
        """Runs for a tenth of a second."""
        self.now += STEP
        if self.wrong('dies') and self.now > 60.0 and not self._revives_at:
            self._revives_at = self.now + 40.0
            self.publish_will()
        if self.is_dead or self._starts_again():
            return
        for name, end in list(self.ends.items()):
            if self.now >= end:
                del self.ends[name]
                (self.actions if name in self.actions else self.instant)[name][
                    'actionStatus'] = 'FINISHED'
        target = next((node for node in self.nodes if node['released']), None)
        self.driving = (target is not None and not self.paused and not self.ends
                        and not self.is_stuck)
        if self.driving and target:
            self._drive(target)
        self.tell()

    def _drive(self, target: Json) -> None:
        to = target['nodePosition']['x'] - self.x
        self.x += max(-STEP, min(STEP, to))
        if abs(to) <= STEP:
            if self.wrong('ignores fields'):
                self.x += 0.05
            self.theta = math.pi if target['nodeId'] == 'n0' and not self.wrong('refuses pi') \
                else 0.0
            self.last = (target['nodeId'], target['sequenceId'])
            self.nodes.remove(target)
            self.edges.pop(0)
            self._begin_actions(target)
            self.driving = bool(self.nodes and self.nodes[0]['released'])


class DirectMaster(BenchMaster):
    """A master that is connected to the vehicle without a broker, and uses the vehicle's time."""

    def __init__(self, vehicle: ToyVehicle) -> None:
        self.vehicle: Optional[ToyVehicle] = vehicle
        major = vehicle.version[0]
        super().__init__(Broker('nowhere', 0), f'uagv/v{major}/Toy/1', vehicle.version)

    def _connect(self, broker: Broker) -> None:
        assert self.vehicle
        self.vehicle.send = self.receive
        self.vehicle.publish('connection', {'connectionState': 'ONLINE'})
        self.vehicle.tell_factsheet()
        self.vehicle.tell()

    def _publish(self, topic: str, payload: bytes) -> None:
        assert self.vehicle
        self.vehicle.receive(topic, payload)

    def now(self) -> float:
        return self.vehicle.now if self.vehicle else 0.0

    def rest(self, seconds: float) -> None:
        assert self.vehicle
        self.vehicle.step()

    def is_retained(self, topic: str) -> bool:
        return True

    def close(self) -> None:
        self.vehicle = None
