"""Orders and layouts made from a graph."""
from __future__ import annotations

import json
from functools import lru_cache

import pytest
import yaml
from vda_messages import ROOT
from vda_schemas import problems

from trajectory_graph import Graph, UnknownVertex, load_graph
from vda5050_bench.layout import lif, main, shortest_edges, track_on
from vda5050_bench.track import Stop, Track, action, read_track
from vda5050_protocol.codec_3 import CODECS
from vda5050_protocol.codecs import VERSION_2_1

GRAPH = str(ROOT / 'maps' / 'lab_graph.yaml')


@lru_cache(maxsize=None)
def lab() -> Graph:
    """The example laboratory."""
    return load_graph(GRAPH)


def test_a_way_is_the_shortest_over_the_graph():
    assert shortest_edges(lab(), (8, 14)) == (1, 2, 3)
    with pytest.raises(UnknownVertex):
        shortest_edges(lab(), (8, 4711))


def test_an_order_is_made_of_a_graph_and_read_as_a_track(capsys, tmp_path):
    assert main(['order', '--graph', GRAPH, '--vertices', '8', '14', '--order-id', 'mission',
                 '--manufacturer', 'M', '--serial', 'S']) == 0
    text = capsys.readouterr().out
    order = json.loads(text)
    assert order['orderId'] == 'mission'
    assert VERSION_2_1.read('order', text.encode())[0].serial_number == 'S'
    assert [node['nodeId'] for node in order['nodes']] == ['8', '10', '12', '14']
    file = tmp_path / 'order.json'
    file.write_text(text)
    assert read_track(str(file)).stops == track_on(lab(), (8, 14), 'map').stops
    assert main(['order', '--graph', GRAPH, '--vertices', '8', '4711']) == 1


@pytest.mark.parametrize('version', sorted(CODECS))
def test_an_order_is_made_in_the_version_of_the_vehicle(capsys, version):
    assert main(['order', '--graph', GRAPH, '--vertices', '8', '14', '--version', version,
                 '--manufacturer', 'M', '--serial', 'S']) == 0
    text = capsys.readouterr().out
    header, order = CODECS[version].read('order', text.encode())
    assert (header.version, len(order.edges)) == (version, 3)
    assert not problems(version, 'order', json.loads(text))


def test_an_action_is_that_of_the_node_if_an_edge_has_the_same_id():
    track = Track((Stop('1', 0.0, 0.0), Stop('2', 1.0, 0.0)), ('2',), ('-2',))
    order = track.order('o', actions={'2': [action('say', 'a')]})
    assert [[found['actionId'] for found in item['actions']]
            for item in (*order['nodes'], *order['edges'])] == [[], ['a'], []]


def test_a_layout_has_every_vertex_and_both_directions():
    layout = lif(lab(), 'lab', 'LD-90', 0.0)['layouts'][0]
    assert {node['nodeId'] for node in layout['nodes']} == {str(v) for v in lab().vertices}
    assert len(layout['edges']) == 2 * len(lab().edges)
    assert yaml.safe_dump(layout)
