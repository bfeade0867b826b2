"""The connection to a real mosquitto on loopback: last will, passwords, TLS, nothing sent twice."""
from __future__ import annotations

import getpass
import json
import os
import queue
import shutil
import socket
import subprocess
import sys
import time

import pytest

from vda5050_mqtt.embedded_broker import configuration, find_mosquitto
from vda5050_mqtt.link import Broker, MqttLink, make_client
from vda5050_mqtt.own_broker import OwnBroker

PREFIX = 'uagv/v2/OMRON/lab'
PASSWORD = 'Cormorant 7'
pytestmark = pytest.mark.skipif(not find_mosquitto(), reason='mosquitto is not installed')


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


class Mosquitto:
    """A broker for a test; `lines` replace the configuration of the embedded broker."""

    def __init__(self, folder, lines='') -> None:
        self.port = free_port()
        folder.chmod(0o755)
        self._file = folder / 'mosquitto.conf'
        # As root, mosquitto would change to another user, who cannot read the test's folder.
        text = (lines or configuration(0)).replace('listener 0', 'listener PORT')
        self._file.write_text(f'user {getpass.getuser()}\n'
                              + text.replace('PORT', str(self.port)))
        self.start()

    def start(self) -> None:
        self.process = subprocess.Popen([find_mosquitto(), '-c', str(self._file)],
                                        stderr=subprocess.DEVNULL)
        deadline = time.monotonic() + 10.0
        while time.monotonic() < deadline:
            with socket.socket() as probe:
                if probe.connect_ex(('127.0.0.1', self.port)) == 0:
                    return
            time.sleep(0.02)
        raise AssertionError('mosquitto does not listen')

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()


@pytest.fixture
def start_broker(tmp_path):
    brokers = []

    def start(lines=''):
        brokers.append(Mosquitto(tmp_path, lines))
        return brokers[-1]
    yield start
    for broker in brokers:
        broker.kill()


class Ends:
    """A link, the changes of its connection, and the messages that it received."""

    def __init__(self, broker: Broker) -> None:
        self.changes: queue.Queue = queue.Queue()
        self.received: queue.Queue = queue.Queue()
        self.link = MqttLink(broker, PREFIX, 'vehicle', lambda state: state.encode(),
                             lambda *message: self.received.put(message),
                             lambda *change: self.changes.put(change))
        self.link.start()

    def changed(self, timeout=10.0):
        return self.changes.get(timeout=timeout)


def listen(port, topic, name='listener'):
    """Subscribes to a topic; returns a queue of its messages (payload, retained), and the client.
    """
    heard: queue.Queue = queue.Queue()
    subscribed: queue.Queue = queue.Queue()
    client = make_client(name)
    client.on_message = lambda _c, _u, message: heard.put((message.payload, bool(message.retain)))
    client.on_subscribe = lambda *_: subscribed.put(True)
    client.connect('127.0.0.1', port)
    client.subscribe(f'{PREFIX}/{topic}', 1)
    client.loop_start()
    subscribed.get(timeout=10.0)
    return heard, client


def test_online_offline_and_the_last_will_are_retained(start_broker):
    broker = start_broker()
    heard, client = listen(broker.port, 'connection')
    ends = Ends(Broker('127.0.0.1', broker.port))
    assert ends.changed() == (True, '')
    assert heard.get(timeout=20.0) == (b'ONLINE', False)
    late, latecomer = listen(broker.port, 'connection', 'latecomer')
    assert late.get(timeout=20.0) == (b'ONLINE', True)
    latecomer.loop_stop()
    ends.link.close()
    assert heard.get(timeout=20.0) == (b'OFFLINE', False)
    killed = Ends(Broker('127.0.0.1', broker.port))
    killed.changed()
    assert heard.get(timeout=20.0) == (b'ONLINE', False)
    killed.link._client._sock.shutdown(socket.SHUT_RDWR)
    assert heard.get(timeout=20.0) == (b'CONNECTIONBROKEN', False)
    assert killed.changed()[0] is False
    client.loop_stop()
    killed.link.close()


def test_what_a_broker_missed_is_not_sent_to_it_later(start_broker):
    broker = start_broker()
    ends = Ends(Broker('127.0.0.1', broker.port))
    ends.changed()
    broker.kill()
    assert ends.changed()[0] is False
    ends.link.publish('state', b'missed')
    broker.start()
    heard, client = listen(broker.port, 'state')
    assert ends.changed() == (True, '')
    ends.link.publish('state', b'fresh')
    assert heard.get(timeout=20.0) == (b'fresh', False)
    client.loop_stop()
    ends.link.close()


def test_a_retained_order_is_told_apart(start_broker):
    broker = start_broker()
    client = make_client('master')
    client.connect('127.0.0.1', broker.port)
    client.loop_start()
    client.publish(f'{PREFIX}/order', b'old', 1, True).wait_for_publish()
    ends = Ends(Broker('127.0.0.1', broker.port))
    ends.changed()
    assert ends.received.get(timeout=20.0) == ('order', b'old', True)
    client.publish(f'{PREFIX}/order', b'', 1, True)  # deletes the retained message
    client.publish(f'{PREFIX}/order', b'new', 0)
    assert ends.received.get(timeout=20.0) == ('order', b'new', False)
    client.loop_stop()
    ends.link.close()


@pytest.mark.skipif(not shutil.which('mosquitto_passwd'), reason='mosquitto_passwd is missing')
def test_a_broker_lets_in_only_who_knows_the_password(start_broker, tmp_path):
    passwords = tmp_path / 'passwords'
    subprocess.run(['mosquitto_passwd', '-b', '-c', str(passwords), 'lab', PASSWORD], check=True,
                   stderr=subprocess.DEVNULL)
    passwords.chmod(0o644)
    broker = start_broker(f'listener PORT 127.0.0.1\nallow_anonymous false\n'
                          f'password_file {passwords}\n')
    wrong = Ends(Broker('127.0.0.1', broker.port, 'lab', 'wrong'))
    connected, reason = wrong.changed()
    assert not connected
    assert 'refuse' in reason.lower()
    assert PASSWORD not in reason
    wrong.link.close()
    right = Ends(Broker('127.0.0.1', broker.port, 'lab', PASSWORD))
    assert right.changed() == (True, '')
    right.link.close()


@pytest.mark.skipif(not shutil.which('openssl'), reason='openssl makes the certificates')
def test_tls_takes_a_broker_of_the_known_authority_only(start_broker, tmp_path):
    for name in ('broker', 'stranger'):
        subprocess.run(
            ['openssl', 'req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '2',
             '-keyout', f'{tmp_path}/{name}.key', '-out', f'{tmp_path}/{name}.pem',
             '-subj', '/CN=127.0.0.1', '-addext', 'subjectAltName=IP:127.0.0.1'],
            check=True, stderr=subprocess.DEVNULL)
        (tmp_path / f'{name}.key').chmod(0o644)
    broker = start_broker(f'listener PORT 127.0.0.1\nallow_anonymous true\n'
                          f'certfile {tmp_path}/broker.pem\nkeyfile {tmp_path}/broker.key\n')
    trusting = Ends(Broker('127.0.0.1', broker.port, ca_file=f'{tmp_path}/broker.pem'))
    assert trusting.changed() == (True, '')
    trusting.link.close()
    wary = Ends(Broker('127.0.0.1', broker.port, ca_file=f'{tmp_path}/stranger.pem'))
    with pytest.raises(queue.Empty):
        wary.changed(timeout=1.5)
    assert not wary.link.connected
    wary.link.close()


def test_the_embedded_broker_is_for_this_computer_only():
    text = configuration(18830)
    assert 'listener 18830 127.0.0.1' in text
    assert json.dumps(text).isascii()


def test_the_configuration_of_the_broker_is_no_file(tmp_path):
    """The broker reads no named file, so another user cannot prepare such a file."""
    port = free_port()
    broker = subprocess.Popen(
        [sys.executable, '-c', 'from vda5050_mqtt.embedded_broker import main; main()',
         '--port', str(port)],
        env={**os.environ, 'TMPDIR': str(tmp_path), 'PYTHONPATH': os.pathsep.join(sys.path)})
    try:
        deadline = time.monotonic() + 10.0
        while not is_open(port):
            assert broker.poll() is None and time.monotonic() < deadline
            time.sleep(0.02)
        assert list(tmp_path.iterdir()) == []
    finally:
        broker.kill()
        broker.wait()


def test_a_broker_starts_again_after_it_was_killed():
    port = free_port()
    broker = OwnBroker(port)
    try:
        for _ in range(2):
            broker.kill()
            broker.start()
            deadline = time.monotonic() + 10.0
            while not is_open(port):
                assert time.monotonic() < deadline, 'the broker does not listen'
                time.sleep(0.02)
    finally:
        broker.close()


def is_open(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(('127.0.0.1', port)) == 0
