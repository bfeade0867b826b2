"""Checks a graph on its site: the whole graph, or only the elements that an edit has changed."""
from __future__ import annotations

from functools import lru_cache
from typing import Dict, List, Optional, Tuple

from shapely.geometry import LineString

from graph_editor.checking.draft_checks import (
    DrawnEdge,
    check_corners,
    check_service,
    check_together,
)
from graph_editor.checking.edge_checks import GRAIN, check_edge, check_vertex, tightest
from graph_editor.checking.findings import Finding, in_order
from graph_editor.checking.rules import CheckRules
from graph_editor.checking.served_floor import ServedFloor
from graph_editor.floor import Floor
from graph_editor.site import MappedSite
from trajectory_graph import Edge, Graph, GraphError, Vertex
from trajectory_graph.editing import Draft

KEPT = 20_000  # largest number of elements with cached findings


class Checker:
    """Checks graphs, and caches the findings about unchanged elements."""

    def __init__(self, rules: CheckRules, site: Optional[MappedSite] = None) -> None:
        """Without a site, only the graph itself is checked, not its place on the floor."""
        self.rules = rules
        self._site = site
        floor = None if site is None else site.floor
        self._served = None if floor is None else ServedFloor(
            floor, rules.robot_width / 2.0, rules.reach)

        @lru_cache(maxsize=KEPT)
        def edge_findings(origin: Vertex, destination: Vertex, edge: Edge) -> Tuple[Finding, ...]:
            return tuple(check_edge(origin, destination, edge, floor, rules))

        @lru_cache(maxsize=KEPT)
        def vertex_findings(vertex: Vertex) -> Tuple[Finding, ...]:
            return tuple(check_vertex(vertex, floor, rules))

        @lru_cache(maxsize=KEPT)
        def drawn(origin: Vertex, destination: Vertex, edge: Edge) -> Optional[DrawnEdge]:
            try:
                curve = Graph((origin, destination), (edge,)).curve(edge.id)
            except GraphError:
                return None
            line = LineString(curve.points)
            return DrawnEdge(curve, line, line.bounds)
        self._drawn = drawn
        self._edge_findings = edge_findings
        self._vertex_findings = vertex_findings

    def of_edge(self, draft: Draft, id: int) -> Tuple[Finding, ...]:
        """Returns the findings that concern one edge, independently of other edges."""
        edge = draft.edges[id]
        return self._edge_findings(draft.vertices[edge.origin], draft.vertices[edge.destination],
                                   edge)

    def of_vertex(self, draft: Draft, id: int) -> Tuple[Finding, ...]:
        """Returns the findings that concern one vertex, independently of other vertices."""
        return self._vertex_findings(draft.vertices[id])

    def all(self, draft: Draft) -> List[Finding]:
        """Returns all findings, errors first."""
        findings: List[Finding] = []
        for id in draft.vertices:
            findings += self.of_vertex(draft, id)
        for id in draft.edges:
            findings += self.of_edge(draft, id)
        curves = self._curves(draft)
        findings += check_together(draft, curves, self.rules)
        if self._site is not None and self._served is not None:
            findings += check_corners(draft, curves, self._site.floor, self.rules)
            findings += check_service(draft, curves, self._served, self._site.places, self.rules)
        return in_order(findings)

    def _curves(self, draft: Draft) -> Dict[int, DrawnEdge]:
        curves = {}
        for edge in draft.edges.values():
            drawn = self._drawn(draft.vertices[edge.origin], draft.vertices[edge.destination],
                                edge)
            if drawn is not None:
                curves[edge.id] = drawn
        return curves


def narrow_edges(graph: Graph, floor: Floor, corridor: float, robot_width: float
                 ) -> Dict[int, float]:
    """Returns the edges that are too narrow for `corridor`, each with the widest corridor that fits
    (m, in whole cm).
    """
    widths = {}
    for id in graph.edges:
        clearance = tightest(floor, graph.curve(id).sample(0.05)).clearance
        if clearance < corridor / 2.0 - GRAIN:
            widths[id] = max(int(200.0 * clearance) / 100.0, robot_width + 0.01)
    return widths
