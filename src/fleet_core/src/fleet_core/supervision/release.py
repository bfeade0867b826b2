"""Finds as many edges as a robot needs among those that are due for it in the order of the plan.

An edge is due only when all robots that come before this robot at a conflicting place, in the order
of the plan, have left the place. A grant is final. So a robot is granted no more edges than it
needs to drive on without braking.

Grants go on while the planner works. The planner's answer fits only if its plans begin with all
edges that were granted meanwhile. So a question names the edges that are *foreseen*: they will be
due before the answer arrives, and the robots may have all of them together now. The planner counts
them as released.
"""
from __future__ import annotations

from typing import Callable, List, Mapping, NamedTuple, Sequence, Tuple

from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.supervision.plan_in_force import PlanInForce


class Due(NamedTuple):
    """The edges that are due for a robot, and the robot that blocks the next edge (empty: none)."""

    edges: List[int]
    waits_for: str = ''


class GrantGoal(NamedTuple):
    """How far a robot is to be granted edges.

    until -- the robot must stop before the edge with this number in its record
    ahead -- m of granted edges that it needs ahead of itself
    """

    until: int
    ahead: float


def has_enough(record: RouteRecord, ahead: float) -> bool:
    """Returns whether a robot has more than `ahead` m to drive, so that no edge is due for it."""
    return not record.is_standing and record.distance_ahead() > ahead


def due_edges(name: str, plan: PlanInForce, records: Mapping[str, RouteRecord],
              goal: GrantGoal) -> Due:
    """Returns the edges that one robot is to be granted.

    The last of these edges is, at the latest, the first one that ends farther ahead than the goal
    demands.
    """
    own, record = plan.plans[name], records[name]
    edges: List[int] = []
    distance = record.distance_ahead()
    number = record.end
    while number < min(goal.until, own.base + len(own.drives)):
        if distance > goal.ahead and not (number == record.end and record.is_standing):
            break
        other = plan.in_the_way(name, number - own.base, records)
        if other:
            return Due(edges, other)
        edge = own.drives[number - own.base].edge
        edges.append(edge)
        distance += record.graph.curve(edge).length
        number += 1
    return Due(edges)


MayHave = Callable[[Mapping[str, Sequence[int]]], Mapping[str, Tuple[int, ...]]]
"""Takes edges of each robot. Returns the first of these edges: as many as all robots may have at
the same time.
"""


def foreseen_edges(goals: Mapping[str, GrantGoal], plan: PlanInForce,
                   records: Mapping[str, RouteRecord],
                   may_have: MayHave) -> Mapping[str, Tuple[int, ...]]:
    """Returns the edges that the planner may count as released although they are not granted yet.

    They are due according to the present plan already. So the other robots have left all places
    that they have to leave first. And the present plan is a plan that begins with these edges.

    goals -- of robots that follow the plan; `ahead` includes the distance (m) that they drive until
             the answer comes
    """
    due = {name: due_edges(name, plan, records, goal).edges for name, goal in goals.items()
           if _ends_certainly(records[name])}
    return may_have(due)


def _ends_certainly(record: RouteRecord) -> bool:
    """Returns whether it is certain at which vertex the record ends."""
    return record.last_vertex is not None and (bool(record.ahead) or not record.protocol.held)
