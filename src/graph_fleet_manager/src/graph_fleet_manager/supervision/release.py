"""How far a robot is let go: as far as its turn has come, and no farther than it needs.

A robot is given an edge only when all who use anything in conflict with it before, by the order of
the plan, have left that. So nothing collides whatever is late. What is given is given for good, so
no more of it than the robot needs in order not to brake.
"""
from __future__ import annotations

from typing import AbstractSet, List, Mapping, NamedTuple

from graph_fleet_manager.supervision.plan_in_force import PlanInForce
from graph_fleet_manager.supervision.route_record import RouteRecord


class Release(NamedTuple):
    """Edges that a robot may be given now, and who keeps it from more (empty: nobody)."""

    edges: List[int]
    waits_for: str = ''


def released(name: str, plan: PlanInForce, records: Mapping[str, RouteRecord], until: int,
             ahead: float, closed: AbstractSet[int]) -> Release:
    """What one robot may be given.

    until  -- number of the record's edge before which it must stop in any case
    ahead  -- m: no more than the first edge that ends farther ahead than this is given
    closed -- ids of edges that nobody may be given
    """
    own, record = plan.plans[name], records[name]
    edges: List[int] = []
    distance = record.distance_ahead()
    number = record.end
    while number < min(until, own.base + len(own.drives)):
        if distance > ahead and not (number == record.end and record.is_standing):
            break
        edge = own.drives[number - own.base].edge
        if abs(edge) in closed:
            return Release(edges, f'edge {abs(edge)}, which is closed')
        other = plan.in_the_way(name, number - own.base, records)
        if other:
            return Release(edges, other)
        edges.append(edge)
        distance += record.graph.curve(edge).length
        number += 1
    return Release(edges)
