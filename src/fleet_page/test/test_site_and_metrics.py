"""The data of the site that browsers receive, and the metrics of the fleet for Prometheus."""
import zlib
from dataclasses import replace

import numpy as np
import pytest
from page_builders import graph, page, show_fleet, status

from fleet_page.core.fleet import ShownPlan
from fleet_page.core.latencies import Histogram, ReleaseWatch
from fleet_page.core.metrics import escaped
from fleet_page.core.site import WrongMap, site_values, wall_map
from trajectory_graph import Graph, split_edges


def test_the_site_has_every_vertex_with_its_kind_and_every_edge_with_its_points():
    values = site_values(graph(), {2}, {1}, None, {'agv': 0.4})
    assert values['vertices'][0] == [1, 0.0, 0.0, 'dock', 'dock']
    assert values['vertices'][1][3] == 'parking' and values['vertices'][2][3] == 'vertex'
    assert values['edges'][0] == [1, 1, 2, [0.0, 0.0, 3.0, 0.0], 1]
    assert values['map'] is None and values['radii'] == {'agv': 0.4}


def test_a_vertex_that_divides_an_edge_is_no_place_and_a_section_has_the_name_of_its_edge():
    drawn = graph()
    no_parking = replace(drawn.vertices[6], parking=False)
    cut = split_edges(Graph([no_parking if vertex.id == 6 else vertex
                             for vertex in drawn.vertices.values()], drawn.edges.values()), 1.6)
    values = site_values(cut, (), (), None, {})
    assert {id for id, _, _, kind, _ in values['vertices'] if kind != 'cut'} == set(drawn.vertices)
    assert {edge[4] for edge in values['edges']} == set(drawn.edges)


def test_walls_become_a_picture_whose_top_is_the_last_row():
    walls = wall_map(np.array((100, 0, -1, 0, 0, 0), np.int8), 3, 2, 0.5, -1.0, -2.0)
    assert walls.png.startswith(b'\x89PNG') and (walls.width, walls.height) == (1.5, 1.0)
    at = walls.png.index(b'IDAT')
    length = int.from_bytes(walls.png[at - 4:at], 'big')
    assert zlib.decompress(walls.png[at + 4:at + 4 + length]) == b'\x00\x00\x00\x80'


@pytest.mark.parametrize('values', [
    (b'', 0, 0, 0.1), (b'\0', 2, 1, 0.1), (b'\0', 1, 1, 0.0), (b'\0', 1, 1, float('nan')),
    (b'\0', -1, -1, 0.1)])
def test_a_grid_that_is_none_is_refused(values):
    with pytest.raises(WrongMap):
        wall_map(*values, 0.0, 0.0)


def test_the_metrics_count_robots_missions_and_latencies(tmp_path):
    shown = page(str(tmp_path))
    show_fleet(shown)
    shown.planner.add(0.3)
    shown.model.update_status(status(9, 'PLANNED', deadline='AT_RISK'))
    text = shown.metrics(2)
    for line in ('fleet_manager_up 1', 'fleet_robots{state="BUSY"} 1',
                 'fleet_missions{state="PENDING"} 1', 'fleet_missions{state="PLANNED"} 1',
                 'fleet_mission_deadlines{state="AT_RISK"} 1',
                 'fleet_robot_battery_ratio{robot="a"} 0.75',
                 'fleet_missions_ended_total{state="SUCCEEDED"} 1',
                 'fleet_planner_seconds_bucket{le="0.5"} 1', 'fleet_planner_seconds_count 1',
                 'fleet_page_clients 2'):
        assert line in text.splitlines()
    assert text.endswith('\n')


def test_a_label_cannot_leave_its_quotes():
    assert escaped('a"} 1\nevil\\') == 'a\\"} 1\\nevil\\\\'


def test_a_release_takes_from_the_first_plan_without_to_the_first_with_an_edge():
    watch = ReleaseWatch()
    watch.note_plans({'a': ShownPlan((1,), 0)}, 10.0)
    watch.note_plans({'a': ShownPlan((1,), 0)}, 11.0)
    watch.note_plans({'a': ShownPlan((1,), 1)}, 12.5)
    watch.note_plans({'a': ShownPlan((1,), 1)}, 14.0)
    assert (watch.seconds.count, watch.seconds.sum) == (1, 2.5)


def test_a_histogram_counts_up_to_each_bound():
    histogram = Histogram()
    for value in (0.01, 0.3, 99.0):
        histogram.add(value)
    lines = histogram.lines('x')
    assert lines[0] == 'x_bucket{le="0.05"} 1' and 'x_bucket{le="+Inf"} 3' in lines
