"""The connection to the MQTT broker: last will, ONLINE, OFFLINE, and nothing replayed.

paho's thread has the socket; messages are handed on as they come. Works with paho-mqtt 1.5 to 2.x.
"""
from __future__ import annotations

import socket
import ssl
import threading
from dataclasses import dataclass
from typing import Any, Callable, Dict, Optional, Tuple

import paho.mqtt.client as mqtt

RECONNECT = (1, 2)      # s between tries: the first, and the longest
FAREWELL = 1.0          # s that OFFLINE may take
INBOUND = ('order', 'instantActions')

# 2.1.0, 6.2: quality of service, and whether the broker keeps the last message.
DELIVERY: Dict[str, Tuple[int, bool]] = {
    'connection': (1, True), 'factsheet': (0, True), 'state': (0, False),
    'visualization': (0, False)}


@dataclass(frozen=True)
class Broker:
    """Where the broker is, and how to be let in; files are PEM, empty names none."""

    host: str
    port: int
    username: str = ''
    password: str = ''
    ca_file: str = ''
    cert_file: str = ''
    key_file: str = ''
    keepalive: int = 15

    def __repr__(self) -> str:
        return f'Broker({self.host}:{self.port})'  # the password is shown nowhere


class MqttLink:
    """Publishes and receives under one prefix of topics, `.../<manufacturer>/<serial>`.

    make_connection -- the payload of `connection` for ONLINE, OFFLINE or CONNECTIONBROKEN
    on_message      -- topic, payload and whether the broker had kept it; in paho's thread
    on_change       -- whether it is connected now, and why not; in paho's thread
    """

    def __init__(self, broker: Broker, prefix: str, client_id: str,
                 make_connection: Callable[[str], bytes],
                 on_message: Callable[[str, bytes, bool], None],
                 on_change: Callable[[bool, str], None]) -> None:
        self._prefix = prefix
        self._make_connection = make_connection
        self._on_message = on_message
        self._on_change = on_change
        self._connected = threading.Event()
        self._client = client = make_client(client_id)
        client.on_connect = self._connect
        client.on_disconnect = self._disconnect
        client.on_message = self._message
        client.will_set(f'{prefix}/connection', make_connection('CONNECTIONBROKEN'), 1, True)
        client.reconnect_delay_set(*RECONNECT)
        secure(client, broker)
        client.connect_async(broker.host, broker.port, broker.keepalive)

    def start(self) -> None:
        """Connects, and keeps connecting."""
        self._client.loop_start()

    def close(self) -> None:
        """Says OFFLINE and leaves."""
        if self._connected.is_set():
            self.publish('connection', self._make_connection('OFFLINE'), wait=FAREWELL)
        self._client.disconnect()
        self._client.loop_stop()

    def publish(self, topic: str, payload: bytes, wait: float = 0.0) -> None:
        """Publishes now, or never: what the broker missed is not sent later."""
        if not self._connected.is_set():
            return
        qos, retain = DELIVERY[topic]
        sent = self._client.publish(f'{self._prefix}/{topic}', payload, qos, retain)
        if wait:
            _wait_for(sent, wait)

    @property
    def connected(self) -> bool:
        """Whether the broker is there."""
        return self._connected.is_set()

    # --- paho's thread ----------------------------------------------------------------------------

    def _connect(self, client: mqtt.Client, _userdata: Any, _flags: Any, code: int) -> None:
        if code != 0:
            self._on_change(False, f'the broker refuses: {mqtt.connack_string(code)}')
            return
        client.subscribe([(f'{self._prefix}/{topic}', 0) for topic in INBOUND])
        self._connected.set()
        self.publish('connection', self._make_connection('ONLINE'))
        self._on_change(True, '')

    def _disconnect(self, _client: mqtt.Client, _userdata: Any, code: int) -> None:
        was_connected = self._connected.is_set()
        self._connected.clear()
        if was_connected:
            self._on_change(False, mqtt.error_string(code))

    def _message(self, _client: mqtt.Client, _userdata: Any, message: mqtt.MQTTMessage) -> None:
        if not message.payload:  # the broker is told to forget what it had kept: no message
            return
        self._on_message(message.topic.rsplit('/', 1)[-1], message.payload, bool(message.retain))


def make_client(client_id: str) -> mqtt.Client:
    """A client that does not wait to send, with each version of paho-mqtt."""
    versions = getattr(mqtt, 'CallbackAPIVersion', None)
    client = (mqtt.Client(client_id) if versions is None
              else mqtt.Client(versions.VERSION1, client_id))
    client.on_socket_open = _without_delay
    return client


def secure(client: mqtt.Client, broker: Broker) -> None:
    """Sets user, password and TLS; raises OSError where a file cannot be used."""
    if broker.username:
        client.username_pw_set(broker.username, broker.password or None)
    if broker.ca_file:
        client.tls_set(broker.ca_file, broker.cert_file or None, broker.key_file or None,
                       cert_reqs=ssl.CERT_REQUIRED, tls_version=ssl.PROTOCOL_TLS_CLIENT)


def _without_delay(_client: mqtt.Client, _userdata: Any, sock: Optional[socket.socket]) -> None:
    """Small messages leave at once; without this a loaded broker adds some 40 ms."""
    if sock is not None:
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _wait_for(sent: mqtt.MQTTMessageInfo, seconds: float) -> None:
    """As MQTTMessageInfo.wait_for_publish with a time limit, which 1.5 lacks."""
    ended = threading.Event()

    def wait() -> None:
        sent.wait_for_publish()
        ended.set()

    threading.Thread(target=wait, daemon=True).start()
    ended.wait(seconds)
