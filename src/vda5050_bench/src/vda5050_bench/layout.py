"""Creates orders and layouts for masters from a trajectory graph.

    vda5050_layout order --graph G.yaml --vertices 18 39 52 6 16    an order in JSON
    vda5050_layout lif --graph G.yaml                               a layout (VDMA LIF 1.0)

With --manufacturer and --serial the order has a header and can be sent to the vehicle unchanged.
"""
from __future__ import annotations

import argparse
import json
import sys
import time
import uuid
from typing import Any, Dict, Optional, Sequence, Tuple

from trajectory_graph import Graph, TrajectoryGraphError, load_graph, speed_of
from trajectory_graph.shortest_paths import shortest_route
from vda5050_bench.track import Stop, Track
from vda5050_bench.version_3 import in_3
from vda5050_protocol.headers import timestamp


def shortest_edges(graph: Graph, vertices: Sequence[int]) -> Tuple[int, ...]:
    """Returns the signed edges of the shortest drivable path over the vertices in this sequence.

    Raises NoPath and UnknownVertex.
    """
    return shortest_route(graph, vertices, lambda edge: speed_of(graph, edge) > 0.0)


def track_on(graph: Graph, vertices: Sequence[int], map_id: str) -> Track:
    """Returns the shortest path over the vertices as a track.

    Raises ValueError, NoPath and UnknownVertex.
    """
    if len(vertices) < 2:
        raise ValueError('a path needs two vertices or more')
    edges = shortest_edges(graph, vertices)
    places = [graph.vertex(vertices[0]), *(graph.end_vertex(edge) for edge in edges)]
    return Track(tuple(Stop(str(v.id), v.x, v.y) for v in places), tuple(map(str, edges)),
                 tuple(str(-edge) for edge in edges), map_id)


def track_over(graph_file: Optional[str], vertices: Sequence[int], map_id: str) -> Track:
    """Returns the shortest path on the graph of a file as a track; raises ValueError, OSError."""
    if not graph_file:
        raise ValueError('the track is missing: give --track FILE, or --graph FILE --vertices ...')
    try:
        return track_on(load_graph(graph_file), vertices, map_id)
    except TrajectoryGraphError as error:
        raise ValueError(str(error)) from None


def lif(graph: Graph, map_id: str, vehicle_type: str, created: float) -> Dict[str, Any]:
    """Returns the graph as a layout for masters: VDMA Layout Interchange Format 1.0.0.

    created -- time of the export, s since 1970
    """
    nodes = [{'nodeId': str(v.id), 'nodeName': v.label, 'mapId': map_id,
              'nodePosition': {'x': v.x, 'y': v.y},
              'vehicleTypeNodeProperties': [{'vehicleTypeId': vehicle_type}]}
             for v in graph.vertices.values()]
    edges = []
    for edge in graph.edges.values():
        for signed, speed in ((edge.id, edge.velocity_forward),
                              (-edge.id, edge.velocity_backwards)):
            if speed > 0.0:
                edges.append({
                    'edgeId': str(signed), 'startNodeId': str(graph.start_vertex(signed).id),
                    'endNodeId': str(graph.end_vertex(signed).id),
                    'vehicleTypeEdgeProperties': [{
                        'vehicleTypeId': vehicle_type, 'vehicleOrientation': 0.0,
                        'rotationAllowed': True}]})
    stations = [{'stationId': f'charger_{v.id}', 'interactionNodeIds': [str(v.id)]}
                for v in graph.vertices.values() if v.dock or v.label == 'dock']
    return {'metaInformation': {'projectIdentification': map_id, 'creator': 'vda5050_layout',
                                'exportTimestamp': timestamp(created), 'lifVersion': '1.0.0'},
            'layouts': [{'layoutId': map_id, 'layoutVersion': '1', 'nodes': nodes, 'edges': edges,
                         'stations': stations}]}


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the program; returns 0, or 1 if the graph or the vertices are wrong."""
    parser = argparse.ArgumentParser(prog='vda5050_layout', description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('what', choices=('order', 'lif'))
    parser.add_argument('--graph', required=True, help='trajectory graph (YAML)')
    parser.add_argument('--vertices', type=int, nargs='+', default=[],
                        help='vertices over which the order leads')
    parser.add_argument('--order-id', default='', help='orderId; default: a random id')
    parser.add_argument('--manufacturer', default='', help='manufacturer of the vehicle')
    parser.add_argument('--serial', default='', help='serialNumber of the vehicle')
    parser.add_argument('--version', default='2.1.0', help='version of VDA 5050 of the order')
    parser.add_argument('--map-id', default='map')
    parser.add_argument('--vehicle-type', default='LD-90', help='vehicle type in the layout')
    options = parser.parse_args(arguments)
    try:
        if options.what == 'order':
            track = track_over(options.graph, options.vertices, options.map_id)
            result = track.order(options.order_id or uuid.uuid4().hex[:12])
            if options.version.startswith('3.'):
                result = dict(in_3('order', result))
            if options.manufacturer and options.serial:
                result = {'headerId': 0, 'timestamp': timestamp(time.time()),
                          'version': options.version,
                          'manufacturer': options.manufacturer, 'serialNumber': options.serial,
                          **result}
        else:
            result = lif(load_graph(options.graph), options.map_id, options.vehicle_type,
                         time.time())
    except (OSError, ValueError, TrajectoryGraphError) as error:
        print(f'vda5050_layout: {error}', file=sys.stderr)
        return 1
    print(json.dumps(result, indent=1))
    return 0
