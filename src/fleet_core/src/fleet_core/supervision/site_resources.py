"""The resources of a site, as its work file describes them, and the docks of its fleet."""
from __future__ import annotations

from typing import Dict, Iterable, Mapping, Tuple

from fleet_core.fleet import Fleet
from fleet_core.interlocking.resources import Resource, ResourceKind
from fleet_core.work.chargers import Charger
from fleet_core.work.devices import DeviceKind
from fleet_core.work.site_work import SiteWork
from trajectory_graph import Graph

_KINDS: Mapping[DeviceKind, ResourceKind] = {
    DeviceKind.DOOR: ResourceKind.DOOR,
    DeviceKind.AIR_LOCK: ResourceKind.AIR_LOCK,
    DeviceKind.LIGHT: ResourceKind.LIGHT}


def chargers_of(work: SiteWork, fleet: Fleet, graph: Graph) -> Dict[str, Charger]:
    """Returns the chargers of a site, by name.

    If a robot type charges at a dock that is no charger's place in the work file, this dock is a
    charger of its own.
    """
    found = dict(work.chargers)
    named = {place for one in found.values() for place in one.places}
    docks = {dock for kind in fleet.all_types for dock in kind.docks or ()}
    for vertex in graph.vertices.values():
        if vertex.dock and vertex.id in docks - named:
            name = f'dock_{vertex.id}'
            while name in found or name in work.names:
                name = f'charger_{name}'
            found[name] = Charger(name, (vertex.id,))
    return found


def resources_of(work: SiteWork, chargers: Iterable[Charger] = ()) -> Tuple[Resource, ...]:
    """Returns the resources of a site: one for each device, station, zone and charger.

    Only one robot at a time may use a device. For other resources, their capacity is the limit.
    """
    return (*(Resource(one.name, _KINDS[one.kind], frozenset(one.edges), has_device=True)
              for one in work.devices.values()),
            *(Resource(one.name, ResourceKind.STATION, vertices=frozenset(one.places),
                       capacity=one.capacity) for one in work.stations.values()),
            *(Resource(one.name, ResourceKind.ZONE, frozenset(one.edges),
                       frozenset(one.vertices), one.capacity) for one in work.zones.values()),
            *(Resource(one.name, ResourceKind.CHARGER, vertices=frozenset(one.places),
                       capacity=one.capacity) for one in chargers))
