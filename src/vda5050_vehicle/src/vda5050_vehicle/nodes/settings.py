"""Reads and checks the node's parameters, and creates objects from them before the node runs."""
from __future__ import annotations

import os
from pathlib import Path
from typing import Any, List, Mapping, Tuple

import rospkg
import rospy

from itrci_nav_msgs.msg import Graph as GraphMessage
from node_lifecycle import ConfigurationError, choice, number, parameter
from node_lifecycle.secret_files import warn_if_exposed
from route_protocol.vehicle import milliseconds
from trajectory_graph import Graph, TrajectoryGraphError, load_graph
from trajectory_graph.messages import graph_from_message
from vda5050_mqtt.credentials import WrongCredentials, read_credentials
from vda5050_mqtt.link import Broker
from vda5050_protocol.codec_3 import CODECS
from vda5050_protocol.codecs import Codec
from vda5050_vehicle.core import factsheet as sheet
from vda5050_vehicle.core.action_table import ActionTable, WrongTable, read_table
from vda5050_vehicle.core.identity import Identity
from vda5050_vehicle.core.vehicle import MakeDriver
from vda5050_vehicle.drivers.order_fields import FIELDS, Abilities
from vda5050_vehicle.drivers.order_graph import Matching
from vda5050_vehicle.drivers.pose_driver import PoseDriver
from vda5050_vehicle.drivers.route_driver import RouteDriver
from vda5050_vehicle.nodes.files import JournalLog, LogReports
from vda5050_vehicle.nodes.parameters import topic_level, yaml_file
from vda5050_vehicle.nodes.robot_watch import Signal, read_signals
from vda5050_vehicle.nodes.ros_actions import check_types


class VehicleSettings:
    """The checked parameters of the node; raises ConfigurationError.

    Each attribute is a parameter.
    """

    def __init__(self) -> None:
        self.codec: Codec = CODECS[choice('~version', '2.1.0', tuple(CODECS))]
        self.identity = Identity(
            topic_level('~manufacturer', ''), topic_level('~serial_number', ''),
            parameter('~map_id', 'map'), parameter('~map_version', '1'))
        self.prefix = '/'.join([topic_level('~interface_name', 'uagv'), self.codec.major,
                                self.identity.manufacturer, self.identity.serial_number])
        self.map_frame = parameter('~map_frame', 'map')
        self.tf_base = ''
        if choice('~pose_source', 'topic', ('topic', 'tf')) == 'tf':
            self.tf_base = parameter('~base_frame', 'base_link')
        self.pose_timeout = number('~pose_timeout', 3.0, 0.2, 60.0)
        self.visualization_period = number('~visualization_period', 0.0, 0.0, 60.0)
        self._read_files()
        self.broker = self._broker()
        self.make_driver = self._driver()
        folder = Path(rospkg.get_ros_home()) / 'vda5050'
        name = f'{self.identity.manufacturer}_{self.identity.serial_number}'
        self.journal = JournalLog(Path(parameter('~journal', '') or folder / f'{name}.json'))
        self.reports = LogReports(Path(parameter('~log_folder', '') or folder / f'{name}_logs'))

    def _read_files(self) -> None:
        path = parameter('~vehicle_file')
        try:
            self.document: Mapping[str, Any] = sheet.check_vehicle(
                yaml_file(path, 'The vehicle file'))
            self.abilities: Abilities = sheet.abilities(self.document, self.identity.map_id,
                                                        self._ignored_fields())
        except sheet.WrongVehicle as error:
            raise ConfigurationError(f'The vehicle file {path}: {error}.') from None
        self.signals: Tuple[Signal, ...] = read_signals(self.document)
        path = parameter('~actions_file', '')
        try:
            self.table = ActionTable(
                read_table(yaml_file(path, 'The actions file')) if path else ())
        except WrongTable as error:
            raise ConfigurationError(f'The actions file {path}: {error}.') from None
        check_types(self.table)

    def _ignored_fields(self) -> Tuple[str, ...]:
        words: List[str] = parameter('~ignored_fields', '').replace(',', ' ').split()
        for word in words:
            if word not in FIELDS:
                raise ConfigurationError(f'~ignored_fields has {word}; the fields are '
                                         f'{" ".join(sorted(FIELDS))}.')
        return tuple(words)

    def _broker(self) -> Broker:
        address = parameter('~broker', '127.0.0.1:1883')
        host, _, port = address.rpartition(':')
        if not host or not port.isdigit() or not 0 < int(port) < 65536:
            raise ConfigurationError(f'~broker is {address!r}, but must be host:port.')
        files = {name: parameter(f'~{name}', '') for name in ('ca_file', 'cert_file', 'key_file')}
        for name, path in files.items():
            if path and not os.access(path, os.R_OK):
                raise ConfigurationError(f'~{name} is {path}, which cannot be read.')
        path = parameter('~credentials_file', '')
        try:
            username, password = read_credentials(path)
        except WrongCredentials as error:
            raise ConfigurationError(f'{error}.') from None
        if path:
            warn_if_exposed('credentials file', path)
        if username and not files['ca_file'] and not _is_local(host):
            rospy.logwarn('The password is sent to the broker at %s unencrypted. Set ~ca_file.',
                          host)
        return Broker(host, int(port), username, password, **files,
                      keepalive=int(number('~keepalive', 15, 1, 3600)))

    def _driver(self) -> MakeDriver:
        can = self.abilities
        matching = Matching(number('~match_radius', 0.3, 0.01, 5.0),
                            number('~start_radius', 0.5, 0.01, 5.0))
        if choice('~driver', 'route', ('route', 'move_base')) == 'move_base':
            return lambda memory: PoseDriver(memory, can, matching)
        graph = _graph()
        return lambda memory: RouteDriver(memory, graph, can, matching, milliseconds)


def _graph() -> Graph:
    path = parameter('~graph_file', '')
    if not path:
        rospy.loginfo('~graph_file is empty: waiting for /graph.')
        try:
            return graph_from_message(rospy.wait_for_message('/graph', GraphMessage))
        except (TrajectoryGraphError, rospy.ROSException) as error:
            raise ConfigurationError(f'/graph: {error}') from None
    try:
        return load_graph(path)
    except (TrajectoryGraphError, OSError) as error:
        raise ConfigurationError(f'{path}: {error}') from None


def _is_local(host: str) -> bool:
    return host in ('localhost', '::1') or host.startswith('127.')
