"""A master over MQTT: it sends messages, stores all messages of the vehicle, and waits for them."""
from __future__ import annotations

import json
import threading
import time
import uuid
from datetime import datetime, timezone
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Set, Tuple

import paho.mqtt.client as mqtt

from vda5050_bench.checker import VehicleChecker
from vda5050_bench.track import action
from vda5050_bench.version_3 import in_3
from vda5050_mqtt.link import Broker, make_client, secure

Message = Dict[str, Any]


class TooLate(Exception):
    """An awaited message did not come in time."""


class BenchMaster:
    """The master of one vehicle.

    messages  -- the received messages by topic, oldest first, with the keys of 2.1
    arrivals  -- the times of their reception by topic, s
    qualities -- the QoS levels by topic
    sent      -- topic and payload of all messages that were sent

    The class has one method for each message that it sends or waits for.
    """

    def __init__(self, broker: Broker, prefix: str, version: str = '2.1.0',
                 on_payload: Optional[Callable[[str, bytes], None]] = None,
                 actions_key: str = 'actions') -> None:
        """`on_payload` receives topic and payload of each message before the message is checked."""
        self.prefix = prefix
        self.manufacturer, self.serial_number = prefix.split('/')[-2:]
        self.checker = VehicleChecker(self.manufacturer, self.serial_number, version)
        self.messages: Dict[str, List[Message]] = {}
        self.arrivals: Dict[str, List[float]] = {}
        self.qualities: Dict[str, Set[int]] = {}
        self.sent: List[Tuple[str, bytes]] = []
        self._version = version
        self._on_payload = on_payload
        self._actions_key = actions_key  # drafts of 2.0 use instantActions
        self._headers: Dict[str, int] = {}
        self._retained: Set[Tuple[str, bytes]] = set()
        self._changed = threading.Condition()
        self._broker = broker
        self._connect(broker)

    def _connect(self, broker: Broker) -> None:
        self._client = client = make_client(f'master_{uuid.uuid4().hex[:12]}')
        client.on_connect = self._subscribe
        client.on_message = lambda _client, _userdata, message: self.receive(
            message.topic.rsplit('/', 1)[-1], message.payload, message.retain, message.qos)
        client.reconnect_delay_set(1, 1)
        secure(client, broker)
        client.connect_async(broker.host, broker.port, broker.keepalive)
        client.loop_start()

    def close(self) -> None:
        """Disconnects from the broker."""
        self._client.disconnect()
        self._client.loop_stop()

    def _subscribe(self, client: mqtt.Client, *_: Any) -> None:
        client.subscribe([(f'{self.prefix}/{topic}', 1) for topic in (
            'connection', 'state', 'factsheet', 'visualization')])

    def receive(self, topic: str, payload: bytes, retained: bool = False, qos: int = 1) -> None:
        """Stores and checks a message of the vehicle; never raises, for any content."""
        moment = self.now()
        if self._on_payload:
            self._on_payload(topic, payload)
        with self._changed:
            self.qualities.setdefault(topic, set()).add(qos)
            if not (retained and (topic, payload) in self._retained):
                found = self.checker.feed(topic, payload)
                if found is not None:
                    self.messages.setdefault(topic, []).append(found)
                    self.arrivals.setdefault(topic, []).append(moment)
            if topic in ('connection', 'factsheet'):  # a broker may repeat retained messages
                self._retained.add((topic, payload))
            self._changed.notify_all()

    @property
    def is_3(self) -> bool:
        """Whether the vehicle uses VDA 5050 3.0."""
        return self._version.startswith('3.')

    def now(self) -> float:
        """Returns the time of this master's clock, in s."""
        return time.monotonic()

    def rest(self, seconds: float) -> None:
        """Waits for a message, at most the given seconds; the caller must hold the condition."""
        self._changed.wait(seconds)

    def is_retained(self, topic: str) -> bool:
        """Returns whether a new client receives the last message on a topic."""
        got = threading.Event()
        client = make_client(f'late_{uuid.uuid4().hex[:12]}')

        def subscribe(*_: Any) -> None:
            client.subscribe(f'{self.prefix}/{topic}')
        client.on_connect = subscribe
        client.on_message = lambda *_: got.set()
        secure(client, self._broker)
        client.connect(self._broker.host, self._broker.port)
        client.loop_start()
        found = got.wait(2.0)
        client.disconnect()
        client.loop_stop()
        return found

    # --- messages of the vehicle ------------------------------------------------------------------

    @property
    def state(self) -> Message:
        """The last state; raises TooLate before the first state."""
        states = self.messages.get('state')
        if not states:
            raise TooLate('no state has come')
        return states[-1]

    def count(self, topic: str = 'state') -> int:
        """Returns the number of messages that came on a topic."""
        return len(self.messages.get(topic, ()))

    def wait(self, predicate: Callable[[Message], Any], seconds: float, what: str,
             topic: str = 'state', after: Optional[int] = None) -> Message:
        """Waits for a message that satisfies `predicate`, and returns it; raises TooLate.

        seconds -- time limit
        what    -- name of the message in the error
        after   -- index of the first message that counts; None: the last message
        """
        deadline = self.now() + seconds
        with self._changed:
            seen = max(self.count(topic) - 1, 0) if after is None else after
            while True:
                while seen < self.count(topic):
                    message = self.messages[topic][seen]
                    if predicate(message):
                        return message
                    seen += 1
                left = deadline - self.now()
                if left <= 0.0:
                    raise TooLate(f'not within {seconds:g} s: {what}; '
                                  f'{summary(topic, self.messages.get(topic))}')
                self.rest(left)

    # --- messages to the vehicle ------------------------------------------------------------------

    def send(self, topic: str, body: Mapping[str, Any]) -> int:
        """Sends a message with a header; returns the number of states that came before.

        body -- the message with the keys of 2.1; it is converted to the version of the vehicle
        """
        if self.is_3:
            body = in_3(topic, body)
        number = self._headers.get(topic, 0)
        self._headers[topic] = number + 1
        now = datetime.now(timezone.utc).isoformat(timespec='milliseconds')
        header = {'headerId': number, 'timestamp': now.replace('+00:00', 'Z'),
                  'version': self._version, 'manufacturer': self.manufacturer,
                  'serialNumber': self.serial_number}
        return self.send_bytes(topic, json.dumps({**header, **body}).encode())

    def send_bytes(self, topic: str, payload: bytes) -> int:
        """Sends a payload with any content; returns the number of states that came before."""
        before = self.count()
        self.sent.append((topic, payload))
        self._publish(topic, payload)
        return before

    def _publish(self, topic: str, payload: bytes) -> None:
        self._client.publish(f'{self.prefix}/{topic}', payload, 0)

    def act(self, action_type: str, action_id: str = '', **parameters: Any) -> str:
        """Sends one instant action; returns its id."""
        action_id = action_id or f'{action_type}-{uuid.uuid4().hex[:8]}'
        self.act_all([action(action_type, action_id, **parameters)])
        return action_id

    def act_all(self, actions: Sequence[Message]) -> int:
        """Sends instant actions; returns the number of states that came before."""
        return self.send('instantActions', {self._actions_key: list(actions)})

    def ended(self, action_id: str, seconds: float = 10.0) -> Message:
        """Waits for the end of an action, and returns its actionState; raises TooLate."""
        state = self.wait(lambda state: status_of(state, action_id) in ('FINISHED', 'FAILED'),
                          seconds, f'the end of action {action_id}')
        return next(found for found in state['actionStates'] if found['actionId'] == action_id)


def summary(topic: str, messages: Optional[Sequence[Message]]) -> str:
    """Returns a short text about the last message on a topic."""
    if not messages:
        return f'no {topic} came'
    last = messages[-1]
    if topic != 'state':
        return f'last {topic}: {json.dumps(last)[:300]}'
    try:
        return f'last state: {_told(last)}'
    except (AttributeError, TypeError):  # a field does not have the type of the standard
        return f'last state: {json.dumps(last)[:300]}'


def _told(last: Message) -> Dict[str, Any]:
    told = {key: last.get(key) for key in ('orderId', 'orderUpdateId', 'lastNodeId', 'driving',
                                           'paused')}
    told['remaining nodes'] = len(last.get('nodeStates', ()))
    told['errors'] = [f'{error.get("errorType")}: {error.get("errorDescription")}'
                      for error in last.get('errors', ())]
    told['actions'] = {a.get('actionId'): a.get('actionStatus')
                       for a in last.get('actionStates', ())}
    return told


def status_of(state: Message, action_id: str) -> Optional[str]:
    """Returns the status of an action in a state; None if the state does not have the action."""
    return next((found['actionStatus'] for found in state['actionStates']
                 if found['actionId'] == action_id), None)


def error_types(state: Message) -> List[str]:
    """Returns the types of all errors of a state."""
    return [error['errorType'] for error in state['errors']]
