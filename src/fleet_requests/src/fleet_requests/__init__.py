"""Requests and commands to the fleet manager, for all programs of this workspace."""
from __future__ import annotations

import random
import time
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Type, Union

import rospy
from std_srvs.srv import Trigger

from itrci_nav_msgs.msg import (
    DeviceRequest,
    EdgeCommand,
    MissionCommand,
    MissionRequest,
    MissionStop,
)
from itrci_nav_msgs.srv import GetMissionStatus, GetMissionStatusResponse

SILENCE = 10.0  # s; after this time without news of a mission, the sender asks for the status
WAIT = 1.0      # s; longest wait for a service, which may not exist
_NEW_ID = random.SystemRandom()


class _Channel(NamedTuple):
    """The topic for a kind of message.

    receiver  -- the name of the node that carries the message out
    complaint -- the text for people if this node does not listen
    """

    topic: str
    receiver: str
    complaint: str


_CHANNELS: Mapping[Type[Any], _Channel] = {
    MissionRequest: _Channel('/mission_request', 'path_supervisor',
                             'No program takes missions: is path_supervisor running?'),
    MissionCommand: _Channel('/mission_command', 'path_supervisor',
                             'No program takes commands: is path_supervisor running?'),
    EdgeCommand: _Channel('/edge_command', 'graph_server',
                          'No program takes commands for edges: is graph_server running?'),
    DeviceRequest: _Channel('/device_request', 'fleet_devices',
                            'No program takes requests for devices: is fleet_devices running?')}


class NotSent(Exception):
    """The receiver of a message does not listen. The text names the receiver."""


class ServiceSilent(Exception):
    """A service does not answer. The text of the error is a clause, not a sentence."""


class ServiceRefused(Exception):
    """A service has answered that it did not carry out the call. The text is its message."""


class Sender:
    """The topic for one kind of message in `_CHANNELS`."""

    def __init__(self, kind: Type[Any]) -> None:
        self.topic, self._receiver, self.complaint = _CHANNELS[kind]
        self._publisher = rospy.Publisher(self.topic, kind, queue_size=100)

    @property
    def is_heard(self) -> bool:
        """Whether the receiver is connected; other nodes, such as the fleet page, do not count."""
        return any(name.rpartition('/')[2] == self._receiver
                   for _, name, *_ in self._publisher.impl.get_stats_info())

    def send(self, message: Any) -> None:
        """Stamps a message with the present time, and sends it. Raises NotSent."""
        if not self.is_heard:
            raise NotSent(self.complaint)
        if isinstance(message, DeviceRequest):  # a message of Open-RMF, which has no header
            message.request_time = rospy.Time.now()
        else:
            message.header.stamp = rospy.Time.now()
        self._publisher.publish(message)

    def repeat(self, message: Any) -> None:
        """Sends a message again, with its first stamp, so that the fleet manager recognises it."""
        self._publisher.publish(message)


class ImpossibleRequest(ValueError):
    """A request cannot be made. The text says why, and what to do instead."""


def mission_request(destinations: Sequence[Union[int, str]], **fields: Any) -> MissionRequest:
    """Returns a request of a mission. If `fields` has no id, the id is random.

    destinations -- ids of vertices, and names of groups; a group stands for any of its places

    Raises ImpossibleRequest for a group with `dwell`.
    """
    fields.setdefault('request_id', _NEW_ID.randint(1, 2 ** 31 - 1))
    if all(isinstance(one, int) for one in destinations):
        return MissionRequest(destination_vertices_id=list(destinations), **fields)
    if fields.get('dwell'):
        raise ImpossibleRequest('A group takes no stay: give one of its places.')
    return MissionRequest(**{**fields, 'stops': visits(destinations)})


def visits(destinations: Sequence[Union[int, str]]) -> List[MissionStop]:
    """Returns stops without steps, at vertices and at places of groups."""
    return [MissionStop(group=one) if isinstance(one, str) else MissionStop(vertex=one)
            for one in destinations]


class MissionNews:
    """The time of the last news of each open mission, to notice a mission whose end was missed.

    The status of a mission is lost if the fleet manager ends before it has sent the status, or if a
    queue overflows. So after a silence the sender of a mission asks for the stored status.
    """

    def __init__(self) -> None:
        self._heard: Dict[int, float] = {}

    def __contains__(self, request_id: int) -> bool:
        """Whether the mission has had news and has not ended."""
        return request_id in self._heard

    def heard(self, request_id: int) -> None:
        """Notes that news of a mission has come now."""
        self._heard[request_id] = time.monotonic()

    def ended(self, request_id: int) -> None:
        """Forgets a mission that has ended."""
        self._heard.pop(request_id, None)

    def silent(self) -> List[int]:
        """Returns the missions without news for at least `SILENCE` s."""
        latest = time.monotonic() - SILENCE
        return [id for id, heard in list(self._heard.items()) if heard <= latest]


def stored_status(request_id: int, stamp: Optional[rospy.Time] = None,
                  ) -> Optional[GetMissionStatusResponse]:
    """Asks for the stored status of a mission. None: the fleet manager does not answer.

    stamp -- the stamp of the request; None: the last mission with this id
    """
    ask = rospy.ServiceProxy('/get_mission_status', GetMissionStatus)
    try:
        return ask(request_id, stamp or rospy.Time())
    except rospy.ServiceException:  # perhaps a restart: the caller asks again
        return None


def call(service: str, kind: Type[Any] = Trigger, *arguments: Any, wait: float = WAIT,
         requested_by: str = '') -> str:
    """Calls a service whose answer has the fields of Trigger, and returns the answer's message.

    wait         -- s to wait for the service
    requested_by -- the person or program that calls, for the records of the fleet manager. It is
                    in the header of the connection, because a Trigger has no field for it

    Raises ServiceSilent and ServiceRefused.
    """
    try:
        rospy.wait_for_service(service, wait)
        answer = rospy.ServiceProxy(service, kind, headers={
            'requested_by': requested_by} if requested_by else None)(*arguments)
    except (rospy.ROSException, rospy.ServiceException) as error:
        raise ServiceSilent(f'{service} does not answer ({error})') from None
    if not answer.success:
        raise ServiceRefused(str(answer.message))
    return str(answer.message)
