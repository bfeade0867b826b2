"""The resources of a site, as its devices and stations make them."""
from __future__ import annotations

from typing import Mapping, Tuple

from fleet_core.interlocking.resources import Resource, ResourceKind
from fleet_core.work.devices import DeviceKind
from fleet_core.work.site_work import SiteWork

_KINDS: Mapping[DeviceKind, ResourceKind] = {
    DeviceKind.DOOR: ResourceKind.DOOR,
    DeviceKind.AIR_LOCK: ResourceKind.AIR_LOCK,
    DeviceKind.LIGHT: ResourceKind.LIGHT}


def resources_of(work: SiteWork) -> Tuple[Resource, ...]:
    """The resources of a site: one for each device and each station.

    A device is for one robot at a time. A station is for as many as its capacity says.
    """
    return (*(Resource(one.name, _KINDS[one.kind], frozenset(one.edges), has_device=True)
              for one in work.devices.values()),
            *(Resource(one.name, ResourceKind.STATION, vertices=frozenset(one.places),
                       capacity=one.capacity) for one in work.stations.values()))
