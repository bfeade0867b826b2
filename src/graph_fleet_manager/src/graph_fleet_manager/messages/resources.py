"""Messages about doors, stations and other resources, and who claims them."""
from __future__ import annotations

from typing import Iterable, List, Mapping, Optional

from fleet_core.interlocking.claims import ClaimState
from fleet_core.interlocking.resources import ResourceKind
from fleet_core.supervision.device_desk import DeviceView
from fleet_core.supervision.resource_view import ResourceView
from itrci_nav_msgs import msg
from route_protocol.devices import DeviceMode

KIND_OF_CODE: Mapping[int, ResourceKind] = {
    getattr(msg.FleetResource, kind.name): kind for kind in ResourceKind}
"""The kind of a resource, by `FleetResource.kind`."""
CLAIM_OF_CODE: Mapping[int, ClaimState] = {
    getattr(msg.ResourceClaim, state.name): state for state in ClaimState}
"""The state of a claim, by `ResourceClaim.state`."""


def resource_messages(views: Iterable[ResourceView]) -> List[msg.FleetResource]:
    """The resources of a site as messages."""
    return [_message(view) for view in views]


def _message(view: ResourceView) -> msg.FleetResource:
    resource, device = view.resource, view.device or DeviceView(DeviceMode.UNKNOWN)
    return msg.FleetResource(
        name=resource.name, kind=getattr(msg.FleetResource, resource.kind.name),
        edges=sorted(resource.edges), vertices=sorted(resource.vertices),
        capacity=resource.capacity, has_device=resource.has_device, device_mode=int(device.mode),
        device_reason=device.why,
        claims=[msg.ResourceClaim(claim.robot, getattr(msg.ResourceClaim, claim.state.name))
                for claim in view.claims])


def device_of(message: msg.FleetResource) -> Optional[DeviceView]:
    """What the device of a resource shows; None: it has none."""
    if not message.has_device:
        return None
    return DeviceView(DeviceMode(message.device_mode), message.device_reason)
