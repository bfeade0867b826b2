"""How far a robot's turn has come by the plan, and no farther than it needs.

An edge is due only when all robots that use anything in conflict with it before, by the order of
the plan, have left that. What is granted is granted for good, so no more of it than the robot needs
in order not to brake.
"""
from __future__ import annotations

from typing import List, Mapping, NamedTuple

from graph_fleet_manager.interlocking.route_record import RouteRecord
from graph_fleet_manager.supervision.plan_in_force import PlanInForce


class Due(NamedTuple):
    """Edges that are a robot's next ones now, and the robot that keeps it from more (empty: none).
    """

    edges: List[int]
    waits_for: str = ''


def has_enough(record: RouteRecord, ahead: float) -> bool:
    """Has a robot more than so many m ahead, so that no edge is due for it?"""
    return not record.is_standing and record.distance_ahead() > ahead


def due_edges(name: str, plan: PlanInForce, records: Mapping[str, RouteRecord], until: int,
              ahead: float) -> Due:
    """What one robot is to be granted.

    until -- number of the record's edge before which it must stop in any case
    ahead -- m: no more than the first edge that ends farther ahead than this is due
    """
    own, record = plan.plans[name], records[name]
    edges: List[int] = []
    distance = record.distance_ahead()
    number = record.end
    while number < min(until, own.base + len(own.drives)):
        if distance > ahead and not (number == record.end and record.is_standing):
            break
        other = plan.in_the_way(name, number - own.base, records)
        if other:
            return Due(edges, other)
        edge = own.drives[number - own.base].edge
        edges.append(edge)
        distance += record.graph.curve(edge).length
        number += 1
    return Due(edges)
