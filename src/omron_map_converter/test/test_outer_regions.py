"""The outside of the floor, as points along the offset outline."""
import numpy as np
import pytest
from converter_builders import LAB

from omron_map_converter.corridors import CorridorRules, corridors_of
from omron_map_converter.outer_regions import STEP, outer_regions
from trajectory_graph import load_graph, split_edges


@pytest.mark.filterwarnings('error')
def test_a_graph_cut_into_sections_has_even_outlines():
    """Where sections meet, corners of the floor differ by at most a thousandth of a millimetre."""
    graph = split_edges(load_graph(str(LAB / 'lab_graph.yaml')), 1.5)
    regions = list(outer_regions(corridors_of(graph, CorridorRules()).floor))
    assert len(regions) > 3
    for region in regions:
        assert np.hypot(*region.directions.T) == pytest.approx(1.0)
        for ring in region.rings:
            points = region.points[ring]
            assert np.hypot(*(np.roll(points, -1, axis=0) - points).T).max() <= STEP + 1e-6
