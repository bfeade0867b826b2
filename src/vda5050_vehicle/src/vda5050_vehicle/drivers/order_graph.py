"""Maps the nodes and edges of an order to vertices and edges of a trajectory graph."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

from trajectory_graph import Graph, Vertex, speed_of
from vda5050_protocol import problems as e
from vda5050_protocol.values import OrderEdge, OrderNode
from vda5050_vehicle.drivers.driver import Leg, NotDrivable
from vda5050_vehicle.drivers.robot_view import RobotPose


@dataclass(frozen=True)
class Matching:
    """The distances for the matching of positions, in m.

    radius -- a node's position matches a vertex within this distance
    near   -- the robot is at a position, or on a curve, within this distance
    """

    radius: float = 0.3
    near: float = 0.5


class OrderGraph:
    """Matches nodes by id, label or position, and edges by id or by the vertices that they join."""

    def __init__(self, graph: Graph, matching: Matching) -> None:
        self.graph = graph
        self._matching = matching
        by_label: Dict[str, List[Vertex]] = {}
        for vertex in graph.vertices.values():
            by_label.setdefault(vertex.label, []).append(vertex)
        self._by_name: Mapping[str, Vertex] = {
            **{label: found[0] for label, found in by_label.items() if label and len(found) == 1},
            **{str(vertex.id): vertex for vertex in graph.vertices.values()}}

    def vertex(self, node: OrderNode) -> Optional[Vertex]:
        """Returns the vertex of a node; None if the node only has a position away from vertices.

        Raises NotDrivable if id and position contradict each other, or if both are missing.
        """
        vertex, position = self._by_name.get(node.node_id), node.position
        if position is None:
            if vertex is None:
                raise NotDrivable(e.NO_ROUTE, f'there is no vertex {node.node_id!r}, and the '
                                  'node has no position', 'nodeId')
            return vertex
        nearest = self._nearest(position.x, position.y)
        if vertex is None:
            return nearest
        away = math.dist(vertex.position, (position.x, position.y))
        if away > self._matching.radius:
            raise NotDrivable(e.ORDER_ERROR, f'node {node.node_id!r} is {away:.2f} m away from '
                              'the vertex of that name', 'nodePosition')
        return vertex

    def place(self, node: OrderNode) -> Tuple[float, float]:
        """Returns the position (x, y) of a node, in m; raises NotDrivable."""
        vertex, position = self.vertex(node), node.position
        if vertex is not None:
            return vertex.position
        if position is None:
            raise ValueError('a node without a vertex must have a position; see `vertex`')
        return position.x, position.y

    def node_at(self, pose: RobotPose) -> str:
        """Returns the id of the vertex at which the robot stands; '' if there is none."""
        vertex = self._nearest(pose.x, pose.y)
        return '' if vertex is None else str(vertex.id)

    def place_on(self, signed: int, percentage: float) -> Optional[Tuple[float, float]]:
        """Returns the point (x, y) at a percentage of an edge; None if the edge is unknown."""
        if abs(signed) not in self.graph.edges:
            return None
        curve = self.graph.curve(signed)
        return curve.point_at(curve.length * percentage / 100.0)

    def knows(self, name: str) -> bool:
        """Returns whether a vertex has this id or label."""
        return name in self._by_name

    def legs(self, nodes: Sequence[OrderNode], edges: Sequence[OrderEdge]) -> Tuple[Leg, ...]:
        """Returns the legs for the edges of an order; raises NotDrivable."""
        legs = []
        for index, edge in enumerate(edges):
            start, end = self.vertex(nodes[index]), self.vertex(nodes[index + 1])
            if end is None:
                raise NotDrivable(e.NO_ROUTE, f'node {nodes[index + 1].node_id!r} is not at a '
                                  'vertex', 'nodePosition')
            if start is not None and start.id == end.id:  # an edge never joins a vertex to itself
                legs.append(Leg(0, 0.0, *end.position))
                continue
            signed = (self._edge_from_place(nodes[index], edge, end, index)
                      if start is None else self._edge_between(start, end, edge))
            legs.append(Leg(signed, self.graph.curve(signed).length, *end.position))
        return tuple(legs)

    def approach(self, first: int, pose: RobotPose, passing: float, corridor: float
                 ) -> Tuple[int, ...]:
        """Returns the edge on which a robot drives to the start of an order's first edge.

        No edge is needed if the robot stands at this start or on the first edge, or if the order
        begins with a leg without length (`first` is 0). Otherwise the result is the edge on which
        the robot stands.
        passing  -- distance within which a robot is at a vertex, m
        corridor -- distance within which a robot is on a curve, m
        Raises NotDrivable if the robot stands on no edge that leads to the start.
        """
        if not first:
            return ()
        start = self.graph.start_vertex(first)
        if (math.dist(start.position, (pose.x, pose.y)) <= passing
                or self._stands_on(first, pose, passing, corridor)):
            return ()
        leading = [-signed for signed in self.graph.edges_from(start.id)
                   if self._is_allowed(-signed)
                   and self._stands_on(-signed, pose, passing, corridor)]
        if not leading:
            raise NotDrivable(
                e.NO_ROUTE, f'the robot stands {math.dist(start.position, (pose.x, pose.y)):.2f} m '
                f'away from vertex {start.id}, on no edge that leads there', 'nodes')
        return min(leading, key=lambda signed: self._distance(signed, pose)),

    def _stands_on(self, signed: int, pose: RobotPose, passing: float, corridor: float) -> bool:
        """Returns whether the robot is on the edge, and not yet at the end of the edge."""
        curve = self.graph.curve(signed)
        place = curve.project(pose.x, pose.y)
        return place.distance <= corridor and curve.length - place.arc_length > passing

    def _distance(self, signed: int, pose: RobotPose) -> float:
        return self.graph.curve(signed).project(pose.x, pose.y).distance

    def _edge_between(self, start: Vertex, end: Vertex, edge: OrderEdge) -> int:
        joining = [signed for signed in self.graph.edges_from(start.id)
                   if self.graph.end_vertex(signed).id == end.id and self._is_allowed(signed)]
        return self._choose(joining, edge, f'vertices {start.id} and {end.id}')

    def _edge_from_place(self, node: OrderNode, edge: OrderEdge, end: Vertex, index: int) -> int:
        """Returns the edge that starts at a position; only for the first node of an order.

        After a cancellation the robot may stand on an edge, so the next order may start there.
        """
        if index:
            raise NotDrivable(e.NO_ROUTE, f'node {node.node_id!r} is not at a vertex',
                              'nodePosition')
        place = self.place(node)
        leading = [-signed for signed in self.graph.edges_from(end.id)]
        joining = [signed for signed in leading if self._is_allowed(signed)
                   and self.graph.curve(signed).project(*place).distance <= self._matching.near]
        return self._choose(joining, edge, f'the position of node {node.node_id!r} and '
                                           f'vertex {end.id}')

    def _is_allowed(self, signed: int) -> bool:
        """Returns whether the edge may be driven in this direction; a velocity of 0 forbids it."""
        return speed_of(self.graph, signed) > 0.0

    def _choose(self, joining: Sequence[int], edge: OrderEdge, between: str) -> int:
        """Returns the edge that the order names by its id, or else the shortest edge."""
        if not joining:
            raise NotDrivable(e.NO_ROUTE, f'edge {edge.edge_id!r}: the graph has no edge '
                              f'that may be driven between {between}', 'edgeId')
        named = [signed for signed in joining if edge.edge_id in (str(signed), str(abs(signed)))]
        return min(named or joining, key=lambda signed: self.graph.curve(signed).length)

    def _nearest(self, x: float, y: float) -> Optional[Vertex]:
        vertex = min(self.graph.vertices.values(),
                     key=lambda vertex: math.dist(vertex.position, (x, y)))
        within = math.dist(vertex.position, (x, y)) <= self._matching.radius
        return vertex if within else None
