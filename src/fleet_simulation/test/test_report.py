"""The report of simulate_fleet: its statements about random differences, and its map."""
from __future__ import annotations

import re
from datetime import datetime
from pathlib import Path
from typing import List, Sequence

import numpy as np
import pytest

from fleet_core.files.fleet_file import load_fleet
from fleet_core.files.robot_settings import load_settings
from fleet_core.work.devices import Device, DeviceKind
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import Station
from fleet_simulation.demand_file import load_demand
from fleet_simulation.figures import Figures
from fleet_simulation.proposals import proposals
from fleet_simulation.report import html
from fleet_simulation.site import WrongSite, site_of
from fleet_simulation.site_map import site_map
from fleet_simulation.statistics import Band, Side
from fleet_simulation.study import InputFiles, Study
from fleet_simulation.walls import Walls, load_walls
from fleet_simulation.words import in_words
from trajectory_graph import Graph, split_edges

WORK = SiteWork(stations={'press': Station('press', (22,), (23,))},
                devices={'gate': Device('gate', DeviceKind.DOOR, (3,), 5.0)})


def run(robots: int, seed: int, succeeded: int, requested: int = 100) -> Figures:
    return Figures(robots, seed, seconds=3600.0, simulated=3600.0, requested=requested,
                   succeeded=succeeded)


@pytest.fixture(scope='module')
def study(yard: Graph, files_in, tmp_path_factory):
    """Returns a function that makes a study of the yard from the figures of runs."""
    paths = files_in(tmp_path_factory.mktemp('site'))
    site = site_of(yard, load_fleet(paths['fleet']), load_settings(paths['fleet']),
                   load_demand(paths['demand'], yard))

    def made(runs: Sequence[Figures]) -> Study:
        return Study(site, InputFiles('graph.yaml', 'fleet.yaml', 'demand.yaml'),
                     datetime(2026, 11, 27, 9, 30), runs, 1.0, 'simulate_fleet')
    return made


@pytest.mark.parametrize(('mean', 'half', 'side'), [
    (1.0, 0.5, Side.ABOVE), (-1.0, 0.5, Side.BELOW), (1.0, 1.5, Side.UNDECIDED),
    (5.0, float('inf'), Side.UNDECIDED)])
def test_a_difference_is_decided_if_its_confidence_interval_does_not_contain_zero(
        mean, half, side) -> None:
    assert Band(mean, half).side() is side


@pytest.mark.parametrize(('larger', 'sentence'), [
    ((38, 39, 37), 'One more adds less than 5 %.'),
    ((30, 29, 31), 'With one more it is 25 ± 6 % less.'),
    ((40, 41, 40), 'One more adds less than 5 %.'),
    ((41, 41, 41), 'One more adds 3 ± 0 %.'),
    ((30, 60, 35), 'Three seeds are too few to decide what one more adds: 4 ± 100 %.'),
])
def test_what_another_robot_adds_is_told_only_if_the_seeds_decide_it(
        study, larger: Sequence[int], sentence: str) -> None:
    runs = [run(1, seed, 40) for seed in (1, 2, 3)]
    runs += [run(2, seed, number) for seed, number in enumerate(larger, 1)]
    assert sentence in in_words(study(runs))


def test_a_gain_that_the_seeds_decide_stands_in_the_table_and_another_is_marked(study) -> None:
    page = html(study([run(robots, seed, number) for robots, numbers in (
        (1, (40, 40, 40)), (2, (60, 61, 59)), (3, (40, 90, 60)))
        for seed, number in enumerate(numbers, 1)]))
    assert '<td>+50 ± 6 %</td>' in page
    assert re.search(r'<td>\+6 ± \d+ %, too few seeds to decide</td>', page)


@pytest.mark.parametrize(('succeeded', 'sentence'), [
    ((100, 99, 100), 'This serves the demand of 100 missions per hour.'),
    ((50, 52, 51), 'It does not serve the demand of 100 missions per hour: 49 ± 2 % of the '
                   'missions are missing.'),
    ((80, 100, 99), 'Three seeds are too few to decide whether this serves the demand'),
    ((95,), 'One seed is too few to decide whether this serves the demand'),
])
def test_whether_the_demand_is_served_is_told_only_if_the_seeds_decide_it(
        study, succeeded: Sequence[int], sentence: str) -> None:
    assert sentence in in_words(study([run(2, seed, one)
                                       for seed, one in enumerate(succeeded, 1)]))


def test_site_date_demand_fleet_and_runs_stand_at_the_top(study) -> None:
    page = html(study([run(2, seed, 100) for seed in (1, 2)]))
    head = page[:page.index('class="words"')]
    for words in ('graph.yaml: 15 vertices and 18 edges, 8 m x 4 m', '2026-11-27 09:30',
                  'demand.yaml: flow 1 (from vertex 21 to vertex 25), 60 per hour',
                  'fleet.yaml: agv; simulated with 2 robots', '2 runs of 1 h'):
        assert words in head


def texts(picture: str) -> List[str]:
    return re.findall(r'<text [^>]*font-weight="bold"[^>]*>([^<]*)</text>', picture)


def test_stations_their_queues_and_doors_are_on_the_map(yard: Graph) -> None:
    for graph in (yard, split_edges(yard, 1.5)):
        picture = site_map(graph, {}, (), WORK)
        assert sorted(texts(picture)) == ['gate', 'press']
        assert picture.count('<title>station press</title>') == 1
        assert picture.count('<title>queue of station press</title>') == 1
        assert picture.count('<title>door gate</title>') == 1


def test_walls_near_the_graph_are_drawn_and_none_far_away(yard: Graph) -> None:
    near, far = np.array([(1.0, 1.0), (1.05, 1.0), (1.1, 1.0)]), np.array([(90.0, 1.0)])
    strokes = re.findall(r'<path d="([^"]+)"', site_map(yard, {}, (), walls=Walls(near, 0.05)))
    assert len(strokes) == 1
    assert '<path' not in site_map(yard, {}, (), walls=Walls(far, 0.05))


def test_a_map_without_walls_or_that_is_none_is_told_in_one_sentence(tmp_path: Path) -> None:
    for content in (b'no map', None):
        path = tmp_path / 'site.map'
        if content is not None:
            path.write_bytes(content)
        else:
            path.unlink()
        with pytest.raises(WrongSite, match='The walls cannot be drawn: '):
            load_walls(path)


def test_proposals_name_the_edges_that_a_person_has_drawn(yard: Graph) -> None:
    cut = split_edges(yard, 1.5)
    made = proposals(cut, list(cut.edges), 1.0)
    assert len(made) > 5
    for one in made:
        for kind, id in re.findall(r'(edge|vertex) (\d+)', one.what):
            assert int(id) in (yard.edges if kind == 'edge' else yard.vertices), one.what
    assert len({one.name for one in made}) == len(made)
