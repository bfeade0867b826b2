"""Where a vehicle is tried: a row of nodes that it can drive there and back, and orders over it."""
from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple


@dataclass(frozen=True)
class Stop:
    """A node: id, and where it is (m)."""

    node_id: str
    x: float
    y: float


@dataclass(frozen=True)
class Track:
    """Nodes in a row, and the ids of the edges between them, there and back."""

    stops: Tuple[Stop, ...]
    edges: Tuple[str, ...]
    edges_back: Tuple[str, ...]
    map_id: str = 'map'

    def reversed(self) -> Track:
        """The same the other way round."""
        return Track(self.stops[::-1], self.edges_back[::-1], self.edges[::-1], self.map_id)

    def part(self, first: int, last: Optional[int] = None) -> Track:
        """From stop `first` to stop `last`, both included."""
        end = len(self.stops) if last is None else last + 1
        return Track(self.stops[first:end], self.edges[first:end - 1],
                     self.edges_back[first:end - 1], self.map_id)

    def order(self, order_id: str, update: int = 0, base: Optional[int] = None,
              first_sequence: int = 0, start_deviation: float = 0.0,
              actions: Optional[Mapping[str, Sequence[Dict[str, Any]]]] = None) -> Dict[str, Any]:
        """An order over all of it, without header; `base` nodes are released, None: all.

        `actions` by nodeId or edgeId.
        """
        released = len(self.stops) if base is None else base
        actions = actions or {}
        nodes: List[Dict[str, Any]] = [
            {'nodeId': stop.node_id, 'sequenceId': first_sequence + 2 * i,
             'released': i < released,
             'nodePosition': {'x': stop.x, 'y': stop.y, 'mapId': self.map_id},
             'actions': list(actions.get(stop.node_id, ()))}
            for i, stop in enumerate(self.stops)]
        if start_deviation:
            nodes[0]['nodePosition']['allowedDeviationXY'] = start_deviation
        edges = [{'edgeId': edge, 'sequenceId': first_sequence + 2 * i + 1,
                  'released': i + 1 < released, 'startNodeId': self.stops[i].node_id,
                  'endNodeId': self.stops[i + 1].node_id,
                  'actions': list(actions.get(edge, ()))} for i, edge in enumerate(self.edges)]
        return {'orderId': order_id, 'orderUpdateId': update, 'nodes': nodes, 'edges': edges}


def track_from_order(order: Mapping[str, Any]) -> Track:
    """The track of an order in JSON; raises KeyError, TypeError or ValueError."""
    stops = tuple(Stop(str(node['nodeId']), float(node['nodePosition']['x']),
                       float(node['nodePosition']['y'])) for node in order['nodes'])
    edges = tuple(str(edge['edgeId']) for edge in order['edges'])
    if len(stops) < 2 or len(edges) != len(stops) - 1:
        raise ValueError('a track needs two nodes, and one edge between each two')
    return Track(stops, edges, edges, order['nodes'][0]['nodePosition']['mapId'])


def read_track(path: str) -> Track:
    """The track of a file with an order in JSON; raises OSError or ValueError."""
    with open(path, encoding='utf-8') as file:
        try:
            return track_from_order(json.load(file))
        except (KeyError, TypeError) as error:
            raise ValueError(f'{path} is no order whose nodes have positions: {error}') from None


def action(action_type: str, action_id: str, blocking: str = 'NONE', **parameters: Any,
           ) -> Dict[str, Any]:
    """An action in JSON."""
    found: Dict[str, Any] = {'actionType': action_type, 'actionId': action_id,
                             'blockingType': blocking}
    if parameters:
        found['actionParameters'] = [{'key': key, 'value': value}
                                     for key, value in parameters.items()]
    return found


def node_ids(state: Mapping[str, Any]) -> List[str]:
    """Of a state's nodeStates."""
    return [node['nodeId'] for node in state['nodeStates']]
