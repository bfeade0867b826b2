"""`fleet stop` reaches the fleet manager with and without a ROS master, and always ends."""
from __future__ import annotations

import io
import socket
import struct
import threading
from contextlib import closing

import genpy
import pytest
import rosgraph.network
from std_srvs.srv import Trigger, TriggerResponse

from graph_fleet_manager.commands import direct_stop, stop, stop_address
from graph_fleet_manager.commands.command_line import NOT_DONE, WRONG, CommandProblem
from graph_fleet_manager.multimaster.peer_master import MasterApi, NoAnswer


class FleetManager:
    """Serves the fleet manager's service like rospy, for one call."""

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
                connection.recv(1000)  # until the command stops waiting
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
    monkeypatch.setattr(MasterApi, 'service_uri', lambda *_: manager.address)
    assert stop.stop('anna') == 'Every robot was told to stop.'
    assert manager.asked['service'] == '/stop_fleet'
    assert manager.asked['md5sum'] == Trigger._md5sum
    assert manager.asked['requested_by'] == 'anna'


@pytest.mark.parametrize('name', ['localhost', '127.0.0.1', socket.gethostname()])
def test_without_a_master_the_fleet_manager_of_this_computer_is_asked(monkeypatch, name):
    stop_address.note(f'http://{name}:1', FleetManager(STOPPED).address)
    told = stop.stop('anna')
    assert told.endswith('The fleet manager was asked directly. Every robot was told to stop.')
    assert 'refused' in told, 'the log must have a warning'


def test_also_if_the_name_of_this_computer_has_no_address(monkeypatch):
    monkeypatch.setattr(socket, 'gethostname', lambda: 'no-such-computer.invalid')
    stop_address.note('http://no-such-computer.invalid:1', FleetManager(STOPPED).address)
    assert stop.stop('anna').endswith('Every robot was told to stop.')


def test_a_master_that_has_forgotten_the_fleet_manager_does_not_keep_it_from_the_stop(monkeypatch):
    def unknown(*_):
        raise NoAnswer('no provider')
    monkeypatch.setattr(MasterApi, 'service_uri', unknown)
    stop_address.note('http://127.0.0.1:1', FleetManager(STOPPED).address)
    assert stop.stop('anna').endswith('(no provider). The fleet manager was asked directly. '
                                'Every robot was told to stop.')


def test_the_fleet_manager_of_another_master_is_left_alone(monkeypatch):
    manager = FleetManager(STOPPED)
    stop_address.note('http://127.0.0.1:2', manager.address)
    with pytest.raises(CommandProblem, match='NO ROBOT WAS TOLD TO STOP: .*on this computer[.]'):
        stop.stop('anna')
    assert not manager.asked


@pytest.mark.parametrize('answer, header, words', [
    (None, None, 'does not answer'), (STOPPED, {'error': 'not a provider'}, 'not a provider')])
def test_a_fleet_manager_that_hangs_or_is_another_program_is_no_end_of_waiting(
        answer, header, words):
    stop_address.note('http://127.0.0.1:1', FleetManager(answer, header).address)
    with pytest.raises(CommandProblem, match=words) as failure:
        stop.stop('anna')
    assert failure.value.status == WRONG


def test_a_stop_that_is_not_done_says_so():
    answer = TriggerResponse(False, 'the disk hangs')
    stop_address.note('http://127.0.0.1:1', FleetManager(answer).address)
    with pytest.raises(CommandProblem, match='the disk hangs') as failure:
        stop.stop('anna')
    assert failure.value.status == NOT_DONE


@pytest.mark.parametrize('noted', ['', 'http://here', 'rosrpc://127.0.0.1:nothing', '\0'])
def test_a_damaged_file_is_no_crash(noted):
    stop_address.note('http://127.0.0.1:1', noted)
    with pytest.raises(CommandProblem, match='NO ROBOT'):
        stop.stop('anna')


# -- without a fleet manager that answers ---------------------------------------------------------


class Route:
    """Replaces rospy's publisher of a robot's routes. Only robots in `connected` get routes."""

    routes: dict = {}
    connected: tuple = ()

    def __init__(self, topic, kind, queue_size, latch) -> None:
        self.topic, self.sent, self.is_open = topic, [], True
        self.routes[topic] = self

    def publish(self, message) -> None:
        message.serialize(io.BytesIO())
        self.sent.append(message)

    def get_num_connections(self) -> int:
        return int(self.topic in self.connected)

    def unregister(self) -> None:
        self.is_open = False


TOPICS = {'/a/target_route': 'itrci_nav_msgs/TargetRoute', '/fleet_state': 'x/FleetState',
          '/b/target_route': 'itrci_nav_msgs/TargetRoute', '/c/target_route': 'std_msgs/String'}


@pytest.fixture
def hung(monkeypatch):
    """Provides a fleet manager that accepts calls but does not answer, and a working ROS master."""
    monkeypatch.setattr(stop, 'PATIENCE', 0.1)
    stop_address.note('http://127.0.0.1:1', FleetManager().address)
    monkeypatch.setattr(MasterApi, 'topic_types', lambda *_: TOPICS)
    monkeypatch.setattr(direct_stop, 'init_node', lambda *_, **__: None)
    monkeypatch.setattr(direct_stop, '_fleet', list)
    monkeypatch.setattr(direct_stop, 'REACHED_IN', 0.1)
    monkeypatch.setattr(direct_stop.rospy, 'Publisher', Route)
    monkeypatch.setattr(direct_stop.rospy.Time, 'now', lambda: genpy.Time(5))
    monkeypatch.setattr(Route, 'routes', {})
    monkeypatch.setattr(Route, 'connected', ('/a/target_route', '/b/target_route'))


def test_the_command_stops_the_robots_itself_where_the_fleet_manager_hangs(hung):
    told = stop.stop('anna')
    assert 'does not answer' in told and 'this command told the robots to stop: a, b.' in told
    assert sorted(Route.routes) == ['/a/target_route', '/b/target_route']
    for route in Route.routes.values():
        order, = route.sent
        assert list(order.edges) == [] and order.order == 0
        assert order.header.stamp == genpy.Time(5) and not route.is_open


def test_the_robots_of_the_fleet_alone_are_told_where_they_are_known(hung, monkeypatch):
    monkeypatch.setattr(direct_stop, '_fleet', lambda: ['b'])
    assert 'told the robots to stop: b.' in stop.stop('anna')
    assert list(Route.routes) == ['/b/target_route']


def test_a_robot_that_is_not_connected_is_named(hung, monkeypatch):
    monkeypatch.setattr(Route, 'connected', ('/a/target_route',))
    with pytest.raises(CommandProblem, match='to stop: a[.] .*NOT TOLD.* b: press') as failure:
        stop.stop('anna')
    assert failure.value.status == NOT_DONE


def test_where_no_robot_is_connected_none_was_told(hung, monkeypatch):
    monkeypatch.setattr(Route, 'connected', ())
    with pytest.raises(CommandProblem, match='NO ROBOT WAS TOLD TO STOP'):
        stop.stop('anna')
