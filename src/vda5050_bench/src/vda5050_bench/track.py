"""The track for the test of a vehicle: nodes that it can drive in both directions, and orders."""
from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple


@dataclass(frozen=True)
class Stop:
    """A node of the track: its id and position (m)."""

    node_id: str
    x: float
    y: float


@dataclass(frozen=True)
class Track:
    """The nodes of the track in sequence.

    edges      -- ids of the edges between the nodes in the forward direction
    edges_back -- ids of the same edges in the opposite direction
    """

    stops: Tuple[Stop, ...]
    edges: Tuple[str, ...]
    edges_back: Tuple[str, ...]
    map_id: str = 'map'

    def reversed(self) -> Track:
        """Returns the track in the opposite direction."""
        return Track(self.stops[::-1], self.edges_back[::-1], self.edges[::-1], self.map_id)

    def part(self, first: int, last: Optional[int] = None) -> Track:
        """Returns the part from stop `first` to stop `last` (None: the last), both included."""
        end = len(self.stops) if last is None else last + 1
        return Track(self.stops[first:end], self.edges[first:end - 1],
                     self.edges_back[first:end - 1], self.map_id)

    def order(self, order_id: str, update: int = 0, base: Optional[int] = None,
              first_sequence: int = 0, start_deviation: float = 0.0,
              actions: Optional[Mapping[str, Sequence[Dict[str, Any]]]] = None) -> Dict[str, Any]:
        """Returns an order over the whole track, without header.

        base    -- number of released nodes; None: all nodes
        actions -- the actions by nodeId or edgeId; an id that nodes and edges share means the node
        """
        released = len(self.stops) if base is None else base
        actions = actions or {}
        of_edges = {key: found for key, found in actions.items()
                    if all(key != stop.node_id for stop in self.stops)}
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
                  'actions': list(of_edges.get(edge, ()))} for i, edge in enumerate(self.edges)]
        return {'orderId': order_id, 'orderUpdateId': update, 'nodes': nodes, 'edges': edges}


def track_from_order(order: Mapping[str, Any]) -> Track:
    """Returns the track of an order in JSON; raises KeyError, TypeError or ValueError."""
    stops = tuple(Stop(str(node['nodeId']), float(node['nodePosition']['x']),
                       float(node['nodePosition']['y'])) for node in order['nodes'])
    edges = tuple(str(edge['edgeId']) for edge in order['edges'])
    if len(stops) < 2 or len(edges) != len(stops) - 1:
        raise ValueError('a track needs two nodes or more, and one edge between each two nodes')
    return Track(stops, edges, edges, order['nodes'][0]['nodePosition']['mapId'])


def read_track(path: str) -> Track:
    """Returns the track of a file with an order in JSON; raises OSError or ValueError."""
    with open(path, encoding='utf-8') as file:
        try:
            return track_from_order(json.load(file))
        except (KeyError, TypeError) as error:
            raise ValueError(f'{path} is not an order with positions at all nodes: {error}'
                             ) from None


def action(action_type: str, action_id: str, blocking: str = 'NONE', **parameters: Any,
           ) -> Dict[str, Any]:
    """Returns an action in JSON."""
    found: Dict[str, Any] = {'actionType': action_type, 'actionId': action_id,
                             'blockingType': blocking}
    if parameters:
        found['actionParameters'] = [{'key': key, 'value': value}
                                     for key, value in parameters.items()]
    return found


def node_ids(state: Mapping[str, Any]) -> List[str]:
    """Returns the node ids in the nodeStates of a state."""
    return [node['nodeId'] for node in state['nodeStates']]
