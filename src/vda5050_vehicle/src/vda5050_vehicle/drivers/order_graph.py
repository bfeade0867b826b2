"""Which vertices and edges of a trajectory graph an order means."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

from trajectory_graph import Graph, Vertex
from vda5050_vehicle.drivers.driver import Leg, NotDrivable
from vda5050_vehicle.drivers.robot_view import Pose
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol.values import Edge, Node


@dataclass(frozen=True)
class Matching:
    """How places are matched; m.

    radius -- a node's position belongs to the vertex within this distance
    near   -- the robot is at a place, or on a curve, within this distance
    """

    radius: float = 0.3
    near: float = 0.5


class OrderGraph:
    """Matches nodes by id, by label, or by place; edges by id, else by the vertices they join."""

    def __init__(self, graph: Graph, matching: Matching) -> None:
        self.graph = graph
        self._matching = matching
        by_label: Dict[str, List[Vertex]] = {}
        for vertex in graph.vertices.values():
            by_label.setdefault(vertex.label, []).append(vertex)
        self._by_name: Mapping[str, Vertex] = {
            **{label: found[0] for label, found in by_label.items() if label and len(found) == 1},
            **{str(vertex.id): vertex for vertex in graph.vertices.values()}}

    def vertex(self, node: Node) -> Optional[Vertex]:
        """The vertex that a node means; None where it has only a place of its own.

        Raises NotDrivable where id and place contradict each other, or there is neither.
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
            raise NotDrivable(e.ORDER_ERROR, f'node {node.node_id!r} lies {away:.2f} m away from '
                              'the vertex of that name', 'nodePosition')
        return vertex

    def place(self, node: Node) -> Tuple[float, float]:
        """Where a node is. Raises NotDrivable."""
        vertex, position = self.vertex(node), node.position
        if vertex is not None:
            return vertex.position
        if position is None:
            raise ValueError('`vertex` lets no node through that has neither')
        return position.x, position.y

    def node_at(self, pose: Pose) -> str:
        """Id of the vertex at which the robot stands, empty where it stands at none."""
        vertex = self._nearest(pose.x, pose.y)
        return '' if vertex is None else str(vertex.id)

    def place_on(self, signed: int, percentage: float) -> Optional[Tuple[float, float]]:
        """Where so much of an edge is driven; None where the graph has no such edge."""
        if abs(signed) not in self.graph.edges:
            return None
        curve = self.graph.curve(signed)
        return curve.point_at(curve.length * percentage / 100.0)

    def knows(self, name: str) -> bool:
        """Whether a vertex has this id or label."""
        return name in self._by_name

    def legs(self, nodes: Sequence[Node], edges: Sequence[Edge]) -> Tuple[Leg, ...]:
        """The edges to drive. Raises NotDrivable."""
        legs = []
        for index, edge in enumerate(edges):
            start, end = self.vertex(nodes[index]), self.vertex(nodes[index + 1])
            if end is None:
                raise NotDrivable(e.NO_ROUTE, f'node {nodes[index + 1].node_id!r} lies at no '
                                  'vertex', 'nodePosition')
            signed = (self._edge_from_place(self.place(nodes[index]), edge, end, index)
                      if start is None else self._edge_between(start, end, edge))
            legs.append(Leg(signed, self.graph.curve(signed).length, *end.position))
        return tuple(legs)

    def approach(self, first: int, pose: Pose, passing: float, corridor: float
                 ) -> Tuple[int, ...]:
        """The edges over which a robot comes to the start of an order's first edge: none where it
        stands there or on that edge, else the one on which it stands.

        passing  -- m within which a robot is at a vertex
        corridor -- m within which it is on a curve
        Raises NotDrivable where it stands on none that leads there.
        """
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

    def _stands_on(self, signed: int, pose: Pose, passing: float, corridor: float) -> bool:
        """On an edge, and not at its end yet."""
        curve = self.graph.curve(signed)
        place = curve.project(pose.x, pose.y)
        return place.distance <= corridor and curve.length - place.arc_length > passing

    def _distance(self, signed: int, pose: Pose) -> float:
        return self.graph.curve(signed).project(pose.x, pose.y).distance

    def _edge_between(self, start: Vertex, end: Vertex, edge: Edge) -> int:
        joining = [signed for signed in self.graph.edges_from(start.id)
                   if self.graph.end_vertex(signed).id == end.id and self._is_allowed(signed)]
        return self._choose(joining, edge, f'vertices {start.id} and {end.id}')

    def _edge_from_place(self, place: Tuple[float, float], edge: Edge, end: Vertex,
                         index: int) -> int:
        """The first node may lie on an edge: there an order is begun after a cancellation."""
        if index:
            raise NotDrivable(e.NO_ROUTE, f'node {edge.start_node_id!r} lies at no vertex',
                              'nodePosition')
        leading = [-signed for signed in self.graph.edges_from(end.id)]
        joining = [signed for signed in leading if self._is_allowed(signed)
                   and self.graph.curve(signed).project(*place).distance <= self._matching.near]
        return self._choose(joining, edge, f'the place of node {edge.start_node_id!r} and vertex '
                                           f'{end.id}')

    def _is_allowed(self, signed: int) -> bool:
        """A velocity of 0 forbids a direction."""
        edge = self.graph.edge(signed)
        return (edge.velocity_forward if signed > 0 else edge.velocity_backwards) > 0.0

    def _choose(self, joining: Sequence[int], edge: Edge, between: str) -> int:
        """By id where it names one, else the shortest."""
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
