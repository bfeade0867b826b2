"""A graph in two unconnected parts, such as two halls: a warning, and missions within one part."""
from __future__ import annotations

import pytest
from fleet_builders import AGV, graph_of

from fleet_core.fleet import Fleet
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.site.remarks import remarks
from fleet_core.site.survey import survey
from fleet_core.supervision.missions import MissionState
from graph_fleet_manager.nodes.random_missions import places_by_edge
from world.supervised_fleet import SupervisedFleet

HALLS = graph_of({**{k: (4.0 * k, 0.0) for k in range(1, 6)},
                  **{10 + k: (4.0 * k, 50.0) for k in range(1, 5)}},
                 {**{k: (k, k + 1) for k in range(1, 5)},
                  **{10 + k: (10 + k, 11 + k) for k in range(1, 4)}})


@pytest.fixture
def fleet() -> SupervisedFleet:
    fleet = SupervisedFleet(HALLS, {'a': (AGV, 1), 'b': (AGV, 11), 'c': (AGV, 14)})
    fleet.step()
    return fleet


def test_a_graph_has_its_parts_the_largest_first():
    assert HALLS.parts == (frozenset({1, 2, 3, 4, 5}), frozenset({11, 12, 13, 14}))


def test_the_parts_are_named_in_a_warning_and_nothing_in_them_is_cut_off():
    told = remarks(HALLS, Fleet((AGV,), (), 0.1),
                   survey(RoadNetwork(HALLS), Fleet((AGV,), (), 0.1)))
    warnings = [remark.text for remark in told if remark.warning]
    assert warnings[0] == (
        'The graph has 2 parts, which no edges join: vertices 1, 2, 3, 4, 5; '
        'vertices 11, 12, 13, 14. A mission stays in one part.')
    assert not any('cannot reach' in text for text in warnings)


def test_the_fleets_of_both_parts_run(fleet):
    fleet.request(1, 4, 2)
    fleet.request(2, 13)
    fleet.request(3, 12)
    fleet.run_until_done(1, 2, 3)
    assert {fleet.told(k)[-1] for k in (1, 2, 3)} == {MissionState.SUCCEEDED}
    assert fleet.robot_of(1) == 'a'


@pytest.mark.parametrize('destinations, robot, reason', [
    ((4, 13), '', 'vertices 4 and 13 are in different parts of the graph, which no edges join'),
    ((4,), 'b', 'vertex 4 is in another part of the graph than b')])
def test_a_mission_across_parts_is_refused_with_the_reason(fleet, destinations, robot, reason):
    fleet.request(1, *destinations, robot=robot)
    assert fleet.told(1) == [MissionState.REFUSED]
    assert fleet.statuses[-1].reason == reason


def test_a_part_without_robots_gets_no_mission():
    fleet = SupervisedFleet(HALLS, {'a': (AGV, 1)})
    fleet.step()
    fleet.request(1, 12)
    assert fleet.told(1) == [MissionState.REFUSED]


def test_random_missions_stay_in_one_part():
    places = places_by_edge(HALLS)
    assert places[1] == [1, 2, 3, 4, 5]
    assert places[12] == [11, 12, 13, 14]
