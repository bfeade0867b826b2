"""The claims of robots and the states of devices, as published for the fleet."""
from __future__ import annotations

from dataclasses import dataclass
from typing import List, NamedTuple, Optional, Tuple

from fleet_core.interlocking.claims import ClaimState
from fleet_core.interlocking.resources import Resource
from fleet_core.supervision.device_desk import DeviceView
from fleet_core.supervision.station_desk import QueuePlace
from fleet_core.supervision.supervisor import Supervisor


class ClaimView(NamedTuple):
    """The claim of a robot. LOST is an alarm."""

    robot: str
    state: ClaimState


@dataclass(frozen=True)
class ResourceView:
    """The published state of one resource.

    device   -- the state of its device; None: it has no device
    is_group -- its places are equal, so a mission may name the resource instead of a place
    queue    -- the queue places of a station, in order
    """

    resource: Resource
    device: Optional[DeviceView]
    claims: Tuple[ClaimView, ...]
    is_group: bool = False
    queue: Tuple[QueuePlace, ...] = ()

    @property
    def alarms(self) -> List[str]:
        """Clauses that say what is wrong for the robots at this resource."""
        return [f'{claim.robot} is where it needs the {self.resource}, which does not report that '
                'it is open' for claim in self.claims if claim.state is ClaimState.LOST]


def resource_views(supervisor: Supervisor, now: float) -> List[ResourceView]:
    """Returns all resources of the site, in the order of the work file."""
    claims, devices = supervisor.interlocking.claims, supervisor.devices
    return [ResourceView(
        one, devices.view(one.name, now) if one.has_device else None,
        tuple(ClaimView(name, state) for name in claims.holders(one.name)
              for state in (claims.state(name, one.name),) if state is not None),
        *supervisor.stations.places_of(one.name))
        for one in claims.needs.resources.values()]
