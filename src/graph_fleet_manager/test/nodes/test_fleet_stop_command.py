"""`fleet stop` reaches the fleet manager with a ROS master, without one, and ends in any case."""
from __future__ import annotations

import io
import socket
import struct
import threading
from contextlib import closing

import pytest
import rosgraph.network
from std_srvs.srv import Trigger, TriggerResponse

from graph_fleet_manager.commands import stop
from graph_fleet_manager.commands.command_line import NOT_DONE, WRONG, CommandError
from graph_fleet_manager.files import stop_address
from graph_fleet_manager.multimaster.peer_master import Master, NoAnswer


class FleetManager:
    """Its service, as rospy serves it: one call."""

    def __init__(self, answer=None, header=None) -> None:
        self._server = socket.create_server(('127.0.0.1', 0))
        self.address = f'rosrpc://127.0.0.1:{self._server.getsockname()[1]}'
        self._answer, self._header = answer, header or {'callerid': '/path_supervisor'}
        self.asked = {}
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        with closing(self._server):
            connection, _ = self._server.accept()
        with connection:
            self.asked = rosgraph.network.read_ros_handshake_header(
                connection, io.BytesIO(), 4096)
            rosgraph.network.write_ros_handshake_header(connection, self._header)
            if self._answer is None:
                connection.recv(1000)
                connection.recv(1000)  # until the command gives up
                return
            connection.recv(4)
            content = io.BytesIO()
            self._answer.serialize(content)
            connection.sendall(struct.pack('<BI', 1, len(content.getvalue())) + content.getvalue())


STOPPED = TriggerResponse(True, 'Every robot was told to stop.')


@pytest.fixture(autouse=True)
def no_master(monkeypatch, tmp_path):
    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    monkeypatch.setenv('ROS_MASTER_URI', 'http://127.0.0.1:1')
    monkeypatch.setattr(stop, 'PATIENCE', 0.3)


def test_the_master_tells_where_the_fleet_manager_is(monkeypatch):
    manager = FleetManager(STOPPED)
    monkeypatch.setattr(Master, 'service_uri', lambda *_: manager.address)
    assert stop.stop() == 'Every robot was told to stop.'
    assert manager.asked['service'] == '/stop_fleet'
    assert manager.asked['md5sum'] == Trigger._md5sum


@pytest.mark.parametrize('name', ['localhost', '127.0.0.1', socket.gethostname()])
def test_without_a_master_the_fleet_manager_of_this_computer_is_asked(monkeypatch, name):
    stop_address.note(f'http://{name}:1', FleetManager(STOPPED).address)
    told = stop.stop()
    assert told.endswith('The fleet manager was asked directly. Every robot was told to stop.')
    assert 'refused' in told, 'what happened is said'


def test_a_master_that_has_forgotten_the_fleet_manager_does_not_keep_it_from_the_stop(monkeypatch):
    def unknown(*_):
        raise NoAnswer('no provider')
    monkeypatch.setattr(Master, 'service_uri', unknown)
    stop_address.note('http://127.0.0.1:1', FleetManager(STOPPED).address)
    assert stop.stop().endswith('(no provider). The fleet manager was asked directly. '
                                'Every robot was told to stop.')


def test_the_fleet_manager_of_another_master_is_left_alone(monkeypatch):
    manager = FleetManager(STOPPED)
    stop_address.note('http://127.0.0.1:2', manager.address)
    with pytest.raises(CommandError, match='NO ROBOT WAS TOLD TO STOP: .*on this computer[.]'):
        stop.stop()
    assert not manager.asked


@pytest.mark.parametrize('answer, header, words', [
    (None, None, 'does not answer'), (STOPPED, {'error': 'not a provider'}, 'not a provider')])
def test_a_fleet_manager_that_hangs_or_is_another_program_is_no_end_of_waiting(
        answer, header, words):
    stop_address.note('http://127.0.0.1:1', FleetManager(answer, header).address)
    with pytest.raises(CommandError, match=words) as failure:
        stop.stop()
    assert failure.value.status == WRONG


def test_a_stop_that_is_not_done_says_so():
    answer = TriggerResponse(False, 'the disk hangs')
    stop_address.note('http://127.0.0.1:1', FleetManager(answer).address)
    with pytest.raises(CommandError, match='the disk hangs') as failure:
        stop.stop()
    assert failure.value.status == NOT_DONE


@pytest.mark.parametrize('noted', ['', 'http://here', 'rosrpc://127.0.0.1:nothing', '\0'])
def test_a_damaged_file_is_no_crash(noted):
    stop_address.note('http://127.0.0.1:1', noted)
    with pytest.raises(CommandError, match='NO ROBOT'):
        stop.stop()
