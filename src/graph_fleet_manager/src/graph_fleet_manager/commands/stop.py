"""The command `fleet stop`.

It never waits for a ROS master, and on the computer of the fleet manager it needs none. If the
fleet manager does not answer, the command sends the stop to the robots itself. Only then does it
become a ROS node, because rospy would wait without end for a master that has ended.
"""
from __future__ import annotations

import io
import socket
import struct
from typing import Callable, List, Tuple

import genpy
import rosgraph
import rosgraph.network
from rospy.core import ParameterInvalid, parse_rosrpc_uri
from std_srvs.srv import Trigger, TriggerResponse

from graph_fleet_manager.commands import stop_address
from graph_fleet_manager.commands.command_line import NOT_DONE, CommandProblem
from graph_fleet_manager.commands.direct_stop import stop_robots
from graph_fleet_manager.multimaster.peer_master import MasterApi, NoAnswer

SERVICE = '/stop_fleet'
PATIENCE = 1.0    # s to wait for the answer; after this time, the fleet manager counts as hung
_LONGEST = 10000  # the most bytes of an answer


class NoStop(Exception):
    """The fleet manager did not accept the stop. The text says why, without a full stop."""


def stop(requested_by: str) -> str:
    """Stops every robot. Returns a text for the person; raises CommandProblem if it did not work.

    requested_by -- the person or program that stops the fleet, for the record
    """
    master_uri = rosgraph.get_master_uri()
    sources: Tuple[Tuple[str, Callable[[str], str]], ...] = (
        ('', _told_by_master), ('The fleet manager was asked directly. ', _noted_here))
    troubles: List[str] = []
    asked: List[str] = []
    for said, address_by in sources:
        try:
            address = address_by(master_uri)
            if address in asked:
                continue
            asked.append(address)
            answer = call(address, requested_by)
        except NoStop as trouble:
            troubles.append(str(trouble))
            continue
        told = ''.join(f'{trouble}. ' for trouble in troubles) + said + str(answer.message)
        if not answer.success:
            raise CommandProblem(told, NOT_DONE)
        return told
    return _told_to_robots(master_uri, '. '.join(troubles))


def _told_to_robots(master_uri: str, trouble: str) -> str:
    try:
        told, missed = stop_robots(master_uri)
    except NoAnswer as failure:
        told, missed = (), ()
        trouble += f'. The ROS master does not give the topics of the robots either ({failure})'
    if not told:
        raise CommandProblem(f'NO ROBOT WAS TOLD TO STOP: {trouble}. Is the fleet manager running? '
                             'Set ROS_MASTER_URI, or press the emergency stops.')
    text = (f'{trouble}. So this command told the robots to stop: {", ".join(told)}. If the fleet '
            'manager hangs, it stops the fleet as soon as it continues; end it if it does not '
            'continue')
    if missed:
        raise CommandProblem(f'{text}. NOT TOLD, because they are not connected: '
                             f'{", ".join(missed)}: press their emergency stops.', NOT_DONE)
    return f'{text}.'


def _told_by_master(master_uri: str) -> str:
    try:
        return MasterApi(master_uri).service_uri(SERVICE)
    except NoAnswer as failure:
        raise NoStop(f'The ROS master at {master_uri} does not give the address of the fleet '
                     f'manager ({failure})') from None


def _noted_here(master_uri: str) -> str:
    address = stop_address.noted(master_uri)
    if address is None:
        raise NoStop('No fleet manager of this ROS master has run on this computer')
    return address


def call(address: str, requested_by: str) -> TriggerResponse:
    """Calls the service at an address (rosrpc://host:port), with a timeout.

    Raises NoStop if no answer comes.
    """
    try:
        host, port = parse_rosrpc_uri(address)
        with socket.create_connection((host, port), PATIENCE) as connection:
            rosgraph.network.write_ros_handshake_header(connection, {
                'service': SERVICE, 'md5sum': Trigger._md5sum, 'callerid': '/fleet_stop',
                'requested_by': requested_by})
            header = rosgraph.network.read_ros_handshake_header(connection, io.BytesIO(), 4096)
            if 'error' in header:
                raise ValueError(header['error'])
            connection.sendall(struct.pack('<I', 0))  # an empty request
            done, length = struct.unpack('<BI', _received(connection, 5))
            if length > _LONGEST:
                raise ValueError(f'its answer has {length} bytes')
            content = _received(connection, length)
    except (OSError, ValueError, ParameterInvalid, rosgraph.network.ROSHandshakeException) as error:
        raise NoStop(f'The fleet manager at {address} does not answer ({error})') from None
    if not done:
        raise NoStop(f'The fleet manager failed: {content.decode(errors="replace")}')
    try:
        return TriggerResponse().deserialize(content)
    except genpy.DeserializationError as error:
        raise NoStop(f'The answer of the fleet manager cannot be read ({error})') from None


def _received(connection: socket.socket, count: int) -> bytes:
    """Receives `count` bytes. Raises OSError if they do not come."""
    found = b''
    while len(found) < count:
        more = connection.recv(count - len(found))
        if not more:
            raise ConnectionError('the connection ended')
        found += more
    return found
