"""Checks, with advice, whether the ROS masters of this and another computer can be joined.

The checks use only the XML-RPC API of the masters; no node is started.
"""
from __future__ import annotations

import contextlib
import random
import socket
import threading
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional
from urllib.parse import urlsplit
from xmlrpc.server import SimpleXMLRPCServer

from graph_fleet_manager.multimaster.findings import (
    Checked,
    Grade,
    clock_finding,
    definitions_finding,
)
from graph_fleet_manager.multimaster.peer_master import (
    DISCOVERY_PORT,
    MASTER_PORT,
    TIMEOUT,
    Discovery,
    MasterApi,
    NoAnswer,
)

_CALL_BACK = 3.0     # s within which a master must call back
_ASKED = 5           # the most nodes of the other side to which a test connection is made


class NetworkChecks:
    """All checks between this computer and `host`; a cause is checked before its effects.

    environment -- environment of the shell: ROS_IP, ROS_HOSTNAME, ROS_MASTER_URI
    own         -- this side's message definitions (MD5 sums by type)
    """

    def __init__(self, host: str, environment: Mapping[str, str], own: Mapping[str, str],
                 master_port: int = MASTER_PORT, discovery_port: int = DISCOVERY_PORT) -> None:
        self._host = host
        self._environment = environment
        self._own = own
        self._discovery_port = discovery_port
        self._ros_ip = environment.get('ROS_IP', '')
        self._own_uri = environment.get('ROS_MASTER_URI', f'http://localhost:{MASTER_PORT}')
        self._master = MasterApi(f'http://{host}:{master_port}')
        self._master_port = master_port
        self._address = ''
        self._nodes: Optional[Dict[str, str]] = None

    def run(self) -> Iterator[Checked]:
        """Yields the findings one by one. If the host has no address, no further check is made."""
        name = self._check_name()
        yield name
        if name.level is Grade.WRONG:
            return
        for check in (self._check_ros_ip, self._check_own_master, self._check_master,
                      self._check_call_back, self._check_node_addresses, self._check_node_names,
                      self._check_discovery, self._check_clock, self._check_definitions):
            finding = check()
            if finding is not None:
                yield finding

    # -- this computer ----------------------------------------------------------------------------

    def _check_name(self) -> Checked:
        try:
            self._address = socket.getaddrinfo(self._host, None, socket.AF_INET)[0][4][0]
        except (OSError, UnicodeError) as error:
            return Checked('name', Grade.WRONG, f'{self._host} has no IPv4 address ({error})',
                           'give the address, or add the name to /etc/hosts')
        if self._address.startswith('127.') and self._address != self._host:
            return Checked('name', Grade.WRONG, f'{self._host} is {self._address}, this computer '
                           'itself', 'correct its line in /etc/hosts')
        shown = '' if self._address == self._host else f'{self._host} is '
        return Checked('name', Grade.OK, f'{shown}{self._address}')

    def _check_ros_ip(self) -> Checked:
        towards = address_towards(self._address)
        if not towards:
            return Checked('ROS_IP', Grade.WRONG, f'there is no network route to {self._address}',
                           'connect both computers to the same network')
        advice = f'export ROS_IP={towards}'
        if self._environment.get('ROS_HOSTNAME'):
            return Checked('ROS_IP', Grade.WRONG, 'ROS_HOSTNAME is set and overrides ROS_IP',
                           f'unset ROS_HOSTNAME, then {advice}')
        if not self._ros_ip:
            return Checked('ROS_IP', Grade.WRONG, 'it is not set, so nodes here give a name that '
                           'the other computer may not know', advice)
        if not is_own_address(self._ros_ip):
            return Checked('ROS_IP', Grade.WRONG, f'{self._ros_ip} is no address of this computer',
                           advice)
        if self._ros_ip.startswith('127.') != self._address.startswith('127.'):
            return Checked('ROS_IP', Grade.WRONG, f'{self._ros_ip} cannot be reached from '
                           f'{self._address}', advice)
        if self._ros_ip != towards and not towards.startswith('127.'):
            return Checked('ROS_IP', Grade.WARN, f'{self._ros_ip} is an address of this computer, '
                           f'but the route to {self._address} begins at {towards}', advice)
        return Checked('ROS_IP', Grade.OK, f'{self._ros_ip}')

    def _check_own_master(self) -> Checked:
        try:
            MasterApi(self._own_uri).pid()
        except NoAnswer as silence:
            return Checked('own master', Grade.WRONG, f'no ROS master answers at {self._own_uri} '
                           f'({silence})', 'start this side\'s launch file, or correct '
                           'ROS_MASTER_URI')
        return Checked('own master', Grade.OK, f'{self._own_uri} answers')

    # -- the other master -------------------------------------------------------------------------

    def _check_master(self) -> Checked:
        try:
            self._nodes = self._master.nodes()
        except NoAnswer as silence:
            return Checked('master', Grade.WRONG, f'no ROS master answers at {self._master.uri} '
                           f'({silence})', f'start its launch file there, and open TCP port '
                           f'{self._master_port} in its firewall')
        return Checked('master', Grade.OK, f'{self._master.uri} answers, with {len(self._nodes)} '
                       'nodes')

    def _check_call_back(self) -> Optional[Checked]:
        """Lets the other master call this computer, as it calls the nodes of joined masters."""
        if self._nodes is None:
            return None
        address = self._ros_ip or address_towards(self._address)
        try:
            came = calls_back(self._master, address)
        except (NoAnswer, OSError) as error:
            return Checked('way back', Grade.WRONG, f'it could not be tried ({error})',
                           'correct the faults above first')
        if not came:
            return Checked('way back', Grade.WRONG, f'the master there does not reach this '
                           f'computer at {address}', 'open all TCP ports from 1024 on between the '
                           'two computers in this one\'s firewall, and check ROS_IP')
        return Checked('way back', Grade.OK, f'the master there reaches this computer at {address}')

    def _check_node_addresses(self) -> Optional[Checked]:
        """Connects to nodes of the other side at the addresses and ports that they report."""
        local = self._local_nodes()
        for name, uri in list(local.items())[:_ASKED]:
            where = urlsplit(uri)
            try:
                socket.create_connection((where.hostname or '', where.port or 0), TIMEOUT).close()
            except (OSError, UnicodeError) as error:
                return Checked('nodes', Grade.WRONG, f'{name} there says it is at {uri}, where it '
                               f'is not reached ({error})', f'export ROS_IP={self._address} there '
                               'before its launch file is started, and open all TCP ports from '
                               '1024 on between the two computers')
        if not local:
            return None
        return Checked('nodes', Grade.OK, f'{min(len(local), _ASKED)} nodes there are reached')

    def _local_nodes(self) -> Dict[str, str]:
        """Returns the nodes that run on the other computer: their URIs have the same host as the
        URI of the rosout there.

        The master there also lists nodes of further masters with which it is joined.
        """
        nodes = self._nodes or {}
        where = urlsplit(nodes.get('/rosout', '')).hostname
        return {name: uri for name, uri in nodes.items()
                if where is not None and urlsplit(uri).hostname == where}

    def _check_node_names(self) -> Optional[Checked]:
        """Looks for node names that both sides use: when the masters are joined, ROS ends one of
        the two nodes.
        """
        try:
            own = MasterApi(self._own_uri).nodes()
        except NoAnswer:
            return None
        theirs = self._nodes or {}
        twice = sorted(name for name, uri in own.items() if name not in _ON_EVERY_SIDE
                       and theirs.get(name, uri) != uri)
        if twice:
            return Checked('node names', Grade.WRONG, f'both sides have a node {", ".join(twice)}',
                           'there must be one fleet manager, and each robot needs a robot_name of '
                           'its own')
        return Checked('node names', Grade.OK, 'no node is on both sides')

    # -- master_discovery of the other computer ---------------------------------------------------

    def _check_discovery(self) -> Checked:
        try:
            self._discovery.clock()
        except NoAnswer as silence:
            return Checked('discovery', Grade.WRONG, f'no master_discovery answers at '
                           f'{self._address}:{self._discovery_port} ({silence})',
                           'start it there with multimaster:=true, and open that TCP port and UDP '
                           'port 11511 in its firewall')
        return Checked('discovery', Grade.OK, f'it answers at {self._address}:'
                       f'{self._discovery_port}')

    def _check_clock(self) -> Optional[Checked]:
        with contextlib.suppress(NoAnswer):
            return clock_finding(*self._discovery.clock())
        return None

    def _check_definitions(self) -> Optional[Checked]:
        with contextlib.suppress(NoAnswer):
            return definitions_finding(self._own, self._discovery.definitions(sorted(self._own)))
        return None

    @property
    def _discovery(self) -> Discovery:
        return Discovery(self._address, self._discovery_port)


_ON_EVERY_SIDE = ('/rosout', '/master_discovery', '/master_sync', '/peer_watch')


def address_towards(address: str) -> str:
    """Returns this computer's address on the route to another computer; empty: there is no route.

    It sends nothing.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((address, MASTER_PORT))
        except OSError:
            return ''
        return str(probe.getsockname()[0])


def is_own_address(address: str) -> bool:
    """Returns whether this computer can listen at the address."""
    with socket.socket() as probe:
        try:
            probe.bind((address, 0))
        except (OSError, UnicodeError):
            return False
    return True


def calls_back(master: MasterApi, address: str) -> bool:
    """Returns whether a master can call a server on this computer at `address`.

    The function registers a subscriber and then a publisher of a new topic. So the master must call
    this server, to report the publisher to the subscriber. Afterwards the function removes both.
    Raises NoAnswer, and OSError if no server can listen at the address.
    """
    called = threading.Event()

    def publisher_update(*_: Any) -> List[Any]:
        called.set()
        return [1, '', 0]

    number = random.randrange(10 ** 9)
    node, topic = f'/check_network_{number}', f'/check_network/{number}'
    with SimpleXMLRPCServer((address, 0), logRequests=False) as server:
        server.register_function(publisher_update, 'publisherUpdate')
        threading.Thread(target=server.serve_forever, daemon=True).start()
        uri = f'http://{address}:{server.server_address[1]}/'
        steps: List[Callable[[], Any]] = [
            lambda: master.api.registerSubscriber(node, topic, 'std_msgs/Empty', uri),
            lambda: master.api.registerPublisher(node, topic, 'std_msgs/Empty', uri)]
        back: List[Callable[[], Any]] = [
            lambda: master.api.unregisterPublisher(node, topic, uri),
            lambda: master.api.unregisterSubscriber(node, topic, uri)]
        try:
            for step in steps:
                master.value(step)
            return called.wait(_CALL_BACK)
        finally:
            for step in back:
                with contextlib.suppress(NoAnswer):
                    master.value(step)
            server.shutdown()
