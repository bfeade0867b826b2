"""Messages about doors, stations, other resources and machines, and the robots that use them."""
from __future__ import annotations

from typing import Dict, Iterable, List, Mapping, Optional

from fleet_core.interlocking.claims import ClaimState
from fleet_core.interlocking.resources import ResourceKind
from fleet_core.supervision.device_desk import DeviceView
from fleet_core.supervision.looks import DEVICE_WORDS, ResourceLook, look_of_resource
from fleet_core.supervision.machine_view import MachineState, MachineView
from fleet_core.supervision.resource_view import ResourceView
from fleet_core.work.stations import Station, StationKind
from itrci_nav_msgs import msg
from route_protocol.devices import DeviceMode

KIND_OF_CODE: Mapping[int, ResourceKind] = {
    getattr(msg.FleetResource, kind.name): kind for kind in ResourceKind}
"""The kind of a resource, by `FleetResource.kind`."""
CLAIM_OF_CODE: Mapping[int, ClaimState] = {
    getattr(msg.ResourceClaim, state.name): state for state in ClaimState}
"""The state of a claim, by `ResourceClaim.state`."""


def resource_messages(views: Iterable[ResourceView]) -> List[msg.FleetResource]:
    """Returns the resources of a site as messages."""
    return [_message(view) for view in views]


def machine_messages(views: Iterable[MachineView]) -> List[msg.FleetMachine]:
    """Returns the machines of a site as messages."""
    return [msg.FleetMachine(name=one.name, state=int(one.state), vertices=list(one.places),
                             key=one.key, robot=one.robot, serial=one.serial) for one in views]


def machine_of(message: msg.FleetMachine) -> MachineView:
    """Returns the machine in a message. An unknown state is read as SILENT."""
    state = next((one for one in MachineState if one == message.state), MachineState.SILENT)
    return MachineView(message.name, state, tuple(message.vertices), message.key, message.robot,
                       message.serial)


def _message(view: ResourceView) -> msg.FleetResource:
    resource, device = view.resource, view.device or DeviceView(DeviceMode.UNKNOWN)
    return msg.FleetResource(
        name=resource.name, kind=getattr(msg.FleetResource, resource.kind.name),
        edges=sorted(resource.edges), vertices=sorted(resource.vertices),
        capacity=resource.capacity, has_device=resource.has_device, device_mode=int(device.mode),
        device_reason=device.why,
        claims=[msg.ResourceClaim(claim.robot, getattr(msg.ResourceClaim, claim.state.name))
                for claim in view.claims],
        is_group=view.is_group,
        queue=[msg.QueuePlace(one.vertex, one.robot, one.is_there) for one in view.queue])


def stations_of(messages: Iterable[msg.FleetResource]) -> Dict[str, Station]:
    """Returns the stations of a site, by name, with kind and places from the work file."""
    return {one.name: Station(
        one.name, tuple(one.vertices), tuple(place.vertex for place in one.queue), one.capacity,
        StationKind.GROUP if one.is_group else StationKind.STATION)
        for one in messages if one.kind == msg.FleetResource.STATION}


def device_of(message: msg.FleetResource) -> Optional[DeviceView]:
    """Returns the state of the device of a resource; None: the resource has no device."""
    if not message.has_device:
        return None
    return DeviceView(DeviceMode(message.device_mode), message.device_reason)


def look_of(message: msg.FleetResource) -> ResourceLook:
    """Returns the look of a resource."""
    device = device_of(message)
    return look_of_resource(None if device is None else device.mode,
                            {CLAIM_OF_CODE[claim.state] for claim in message.claims})


def words_of(message: msg.FleetResource) -> str:
    """Returns the kind of a resource, its name, and the state of its device."""
    device = device_of(message)
    shows = '' if device is None else f': {DEVICE_WORDS[device.mode]}'
    return f'{KIND_OF_CODE[message.kind].value} {message.name}{shows}'
