"""The edges that are due for a robot by the plan's order, and no more than it needs.

An edge is due only when all robots that use a conflicting place before, by the order of the plan,
have left that place. A grant is final. So a robot is granted no more than it needs in order not to
brake.
"""
from __future__ import annotations

from typing import List, Mapping, NamedTuple

from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.supervision.plan_in_force import PlanInForce


class Due(NamedTuple):
    """The edges that are due for a robot, and the robot that blocks the next (empty: none)."""

    edges: List[int]
    waits_for: str = ''


def has_enough(record: RouteRecord, ahead: float) -> bool:
    """Has a robot more than `ahead` m to drive, so that no edge is due for it?"""
    return not record.is_standing and record.distance_ahead() > ahead


def due_edges(name: str, plan: PlanInForce, records: Mapping[str, RouteRecord], until: int,
              ahead: float) -> Due:
    """The edges that one robot is to be granted.

    until -- number of the record's edge before which it must stop in any case
    ahead -- m: the first edge that ends farther ahead than this is the last one that is due
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
