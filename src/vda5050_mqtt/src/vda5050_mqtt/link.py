"""The connection to the MQTT broker: last will, ONLINE and OFFLINE.

Messages that could not be sent are not sent again after a reconnection. The thread of paho owns
the socket and passes each received message on at once. Works with paho-mqtt 1.5 to 2.x.
"""
from __future__ import annotations

import socket
import ssl
import threading
from dataclasses import dataclass
from typing import Any, Callable, Dict, Tuple

import paho.mqtt.client as mqtt

RECONNECT = (1, 2)      # s between two attempts to connect: the first pause, the longest pause
FAREWELL = 1.0          # s that the sending of OFFLINE may take
INBOUND = ('order', 'instantActions')

# VDA 5050 2.1.0, 6.2: quality of service, and whether the broker retains the last message.
DELIVERY: Dict[str, Tuple[int, bool]] = {
    'connection': (1, True), 'factsheet': (0, True), 'state': (0, False),
    'visualization': (0, False)}


@dataclass(frozen=True)
class Broker:
    """The address of the broker, and the credentials. The files are PEM files; '': no file."""

    host: str
    port: int
    username: str = ''
    password: str = ''
    ca_file: str = ''
    cert_file: str = ''
    key_file: str = ''
    keepalive: int = 15

    def __repr__(self) -> str:
        return f'Broker({self.host}:{self.port})'  # does not show the password


class MqttLink:
    """Publishes and receives under one prefix of topics, `.../<manufacturer>/<serial>`.

    make_connection -- returns the payload of `connection` for ONLINE, OFFLINE or CONNECTIONBROKEN
    on_message      -- called in paho's thread with the topic, the payload, and whether the message
                       is a retained one
    on_change       -- called in paho's thread with the new state of the connection, and the reason
                       for a disconnection
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
        """Connects, and connects again after each disconnection."""
        self._client.loop_start()

    def close(self) -> None:
        """Sends OFFLINE and disconnects."""
        if self._connected.is_set():
            self.publish('connection', self._make_connection('OFFLINE'), wait=FAREWELL)
        self._client.disconnect()
        self._client.loop_stop()

    def publish(self, topic: str, payload: bytes, wait: float = 0.0) -> None:
        """Publishes a message if the broker is connected; otherwise drops it.

        wait -- s to wait until the message is sent
        """
        if not self._connected.is_set():
            return
        qos, retain = DELIVERY[topic]
        sent = self._client.publish(f'{self._prefix}/{topic}', payload, qos, retain)
        if wait:
            _wait_for(sent, wait)

    @property
    def connected(self) -> bool:
        """Whether the link is connected to the broker."""
        return self._connected.is_set()

    # --- in paho's thread -------------------------------------------------------------------------

    def _connect(self, client: mqtt.Client, _userdata: Any, _flags: Any, code: int) -> None:
        if code != 0:
            self._on_change(
                False, f'the broker refuses the connection: {mqtt.connack_string(code)}')
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
        if not message.payload:  # an empty payload only deletes the broker's retained message
            return
        self._on_message(message.topic.rsplit('/', 1)[-1], message.payload, bool(message.retain))


def make_client(client_id: str) -> mqtt.Client:
    """Returns a client that sends small messages at once, with any version of paho-mqtt."""
    versions = getattr(mqtt, 'CallbackAPIVersion', None)  # since paho-mqtt 2
    options: Dict[str, Any] = ({} if versions is None
                               else {'callback_api_version': versions.VERSION1})
    client = mqtt.Client(client_id=client_id, **options)
    client.on_socket_open = _without_delay
    return client


def secure(client: mqtt.Client, broker: Broker) -> None:
    """Sets user, password and TLS; raises OSError if a file cannot be used."""
    if broker.username:
        client.username_pw_set(broker.username, broker.password or None)
    if broker.ca_file:
        client.tls_set(broker.ca_file, broker.cert_file or None, broker.key_file or None,
                       cert_reqs=ssl.CERT_REQUIRED, tls_version=ssl.PROTOCOL_TLS_CLIENT)


def _without_delay(_client: mqtt.Client, _userdata: Any, sock: Any) -> None:
    """Disables Nagle's algorithm, with which a loaded broker adds some 40 ms."""
    if isinstance(sock, socket.socket):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _wait_for(sent: mqtt.MQTTMessageInfo, seconds: float) -> None:
    """Waits until a message is sent, but at most `seconds`.

    In paho-mqtt 1.5, wait_for_publish has no time limit.
    """
    ended = threading.Event()

    def wait() -> None:
        sent.wait_for_publish()
        ended.set()

    threading.Thread(target=wait, daemon=True).start()
    ended.wait(seconds)
