"""simulate_fleet: its demand, its figures, and the changes of the graph that it proposes."""
from __future__ import annotations

import csv
import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Callable, Dict, List

import pytest

from fleet_core.files.errors import FileError
from fleet_core.files.fleet_file import load_fleet
from fleet_core.files.robot_settings import load_settings
from fleet_core.fleet import Fleet, Robot, RobotType
from fleet_simulation.command import main
from fleet_simulation.demand_file import load_demand
from fleet_simulation.figures import Figures, Use
from fleet_simulation.proposals import Proposal, proposals
from fleet_simulation.simulation import simulate
from fleet_simulation.site import StudiedSite, site_of, with_docks
from trajectory_graph import Graph, load_graph, save_graph

Files = Callable[..., Dict[str, str]]
SATURATED = 'groups: {all: [21, 22, 23, 24, 25]}\nflows:\n- {to: all, saturated: 1.0}\n'


def site(yard: Graph, paths: Dict[str, str]) -> StudiedSite:
    return site_of(yard, load_fleet(paths['fleet']), load_settings(paths['fleet']),
                   load_demand(paths['demand'], yard))


def arguments(paths: Dict[str, str], output: Path, *more: str) -> List[str]:
    return [*(f'--{name}={path}' for name, path in paths.items()), f'--output={output}', *more]


def told(figures: Figures) -> tuple:
    return (figures.succeeded, figures.waits, figures.leads, figures.use, figures.waiting,
            figures.travelled)


def test_a_run_depends_on_its_seed_only(yard: Graph, files: Files) -> None:
    here = site(yard, files(SATURATED))
    one, same, other = (simulate(here, 2, seed, 0.1) for seed in (1, 1, 2))
    assert not one.trouble
    assert one.succeeded > 5
    assert told(one) == told(same) != told(other)


def test_every_moment_of_every_robot_is_told(yard: Graph, files: Files) -> None:
    figures = simulate(site(yard, files(SATURATED)), 3, 1, 0.1)
    assert sum(figures.use.values()) == pytest.approx(3 * figures.seconds, rel=0.02)
    assert sum(figures.waiting.values()) == pytest.approx(figures.use[Use.WAITING])


def test_a_small_demand_is_served_whole(yard: Graph, files: Files) -> None:
    figures = simulate(site(yard, files()), 2, 1, 0.5)
    assert figures.requested > 15
    assert figures.requested - figures.succeeded <= 2
    assert not figures.failures


def test_the_report_is_one_page_without_a_network_and_tables(files: Files, tmp_path: Path,
                                                             capsys) -> None:
    output = tmp_path / 'report'
    assert main(arguments(files(SATURATED), output, '--robots=1..2', '--hours=0.05', '--seeds=2',
                          '--proposals=1')) == 0
    assert 'missions per hour' in capsys.readouterr().out
    page = (output / 'report.html').read_text()
    links: List[str] = []

    class Links(HTMLParser):
        def handle_starttag(self, tag: str, attrs: list) -> None:
            links.extend(value for name, value in attrs if name in ('href', 'src'))
    Links().feed(page)
    assert not links
    assert page.count('<svg') == 4
    rows = list(csv.DictReader((output / 'runs.csv').open()))
    assert [(row['robots'], row['seed']) for row in rows] == [
        ('1', '1'), ('2', '1'), ('1', '2'), ('2', '2')]
    proposed = list(csv.DictReader((output / 'proposals.csv').open()))
    assert len(proposed) == 1
    assert load_graph(output / proposed[0]['graph']).vertices


@pytest.mark.parametrize(('more', 'sentence'), [
    (('--robots=40',), '40 robots are more than the '),
    (('--robots=2..x',), "'2..x' is not a number of robots"),
    (('--seeds=0',), "'0' is not a whole number above 0"),
])
def test_what_cannot_be_simulated_is_told_before_anything_runs(
        files: Files, tmp_path: Path, capsys, more, sentence) -> None:
    try:
        status = main(arguments(files(), tmp_path / 'report', *more))
    except SystemExit as end:
        status = end.code
    assert status == 1
    told = capsys.readouterr().err
    assert sentence in told
    assert told.count('\n') == 1
    assert not (tmp_path / 'report').exists()


def test_a_vertex_to_which_no_robot_can_come_is_told_with_its_line(
        yard: Graph, files: Files) -> None:
    from dataclasses import replace

    from fleet_core.files.errors import FileError
    walled = Graph(yard.vertices.values(), [
        replace(edge, velocity_forward=0.0, velocity_backwards=0.0)
        if 21 in (edge.origin, edge.destination) else edge for edge in yard.edges.values()])
    with pytest.raises(FileError) as error:
        site(walled, files('flows:\n- {to: 21, per_hour: 3}\n'))
    assert error.value.line == 2
    assert error.value.problem.startswith('vertex 21 is not reachable')


def test_a_run_in_which_no_mission_ends_has_a_report(files: Files, tmp_path: Path) -> None:
    assert main(arguments(files(), tmp_path / 'report', '--hours=0.001')) == 0
    assert (tmp_path / 'report' / 'report.html').exists()


def test_an_unreachable_pair_is_told_with_its_line(yard: Graph, files: Files) -> None:
    from dataclasses import replace

    from fleet_core.files.errors import FileError
    island = Graph(yard.vertices.values(), [
        replace(edge, velocity_forward=0.0) if edge.id == 204 else edge
        for edge in yard.edges.values()])
    with pytest.raises(FileError) as error:
        site(island, files())
    assert error.value.line == 2
    assert 'no robot can drive from vertex 21 to vertex 25' in error.value.problem


def test_no_file_of_the_user_is_overwritten_by_a_report(files: Files, tmp_path: Path,
                                                        capsys) -> None:
    (tmp_path / 'mine').mkdir()
    (tmp_path / 'mine' / 'runs.csv').write_text('my own runs')
    few = ('--robots=1', '--hours=0.02', '--seeds=1')
    assert main(arguments(files(SATURATED), tmp_path / 'mine', *few)) == 1
    assert 'name a new or empty folder' in capsys.readouterr().err
    assert (tmp_path / 'mine' / 'runs.csv').read_text() == 'my own runs'
    for _ in range(2):  # an earlier report is replaced
        assert main(arguments(files(SATURATED), tmp_path / 'report', *few)) == 0


def test_a_report_names_the_edges_that_the_user_has_drawn_and_not_their_sections(
        files: Files, tmp_path: Path, capsys, yard: Graph) -> None:
    paths = files(SATURATED)
    assert main(arguments(paths, tmp_path / 'report', '--robots=3', '--hours=0.1', '--seeds=1',
                          '--longest-edge=1.5')) == 0
    page = (tmp_path / 'report' / 'report.html').read_text()
    named = set(map(int, re.findall(r'<title>edge (\d+):', page)))
    assert named == set(yard.edges)
    assert set(map(int, re.findall(r'<tr><td>(\d+)</td><td>[\d.]+ %</td><td>[a-z]', page))) <= named


# -- the demand file -------------------------------------------------------------------------------

def wanted(folder: Path, graph, text: str):
    path = folder / 'demand.yaml'
    path.write_text(text)
    return load_demand(path, graph)


def test_so_many_missions_come_as_the_flow_has_an_hour_and_the_same_of_the_same_seed(
        yard, tmp_path) -> None:
    demand = wanted(tmp_path, yard, 'groups: {all: [21, 22, 23]}\n'
                                    'flows:\n- {from: 25, to: all, per_hour: 100}\n').demand
    drawn = demand.draw(3, 10.0)
    assert drawn == demand.draw(3, 10.0) != demand.draw(4, 10.0)
    assert 900 < len(drawn) < 1100
    assert {request.destinations for request in drawn} == {(25, 21), (25, 22), (25, 23)}


def test_missions_come_in_their_shifts_only(yard, tmp_path) -> None:
    demand = wanted(tmp_path, yard, 'flows:\n- to: 21\n  timetable:\n'
                                    '  - {begin: 1, end: 2, per_hour: 50}\n').demand
    assert all(3600.0 <= request.stamp < 7200.0 for request in demand.draw(1, 8.0))


def test_a_recorded_day_is_driven_as_it_was(yard, tmp_path) -> None:
    (tmp_path / 'day.csv').write_text('time,destinations,priority\n12.5,21 25,3\n3,22,0\n')
    drawn = wanted(tmp_path, yard, 'csv: day.csv\n').demand.draw(1, 1.0)
    assert [(one.stamp, one.destinations, one.priority) for one in drawn] == [
        (3.0, (22,), 0), (12.5, (21, 25), 3)]


@pytest.mark.parametrize(('text', 'line', 'problem'), [
    ('flows:\n- {to: 99, per_hour: 3}\n', 2, 'to is 99, but the graph has no vertex 99'),
    ('flows:\n- {to: yard, per_hour: 3}\n', 2,
     "to is 'yard', which is neither a vertex nor a group; there are no groups"),
    ('flows:\n- {to: 21, per_huor: 3}\n', 2,
     "a flow has the unknown key 'per_huor'; did you mean per_hour?"),
    ('flows:\n- {to: 21}\n', 2, 'a flow needs exactly one of per_hour, timetable and saturated'),
    ('flows:\n- {from: 21, to: 21, per_hour: 3}\n', 2, 'a flow leads from vertex 21 to itself'),
    ('flows:\n- to: 21\n  timetable:\n  - {begin: 3, end: 2, per_hour: 1}\n', 4,
     'a shift ends at 2 h, which is not after its begin at 3 h'),
    ('flows:\n- {to: 21, per_hour: -1}\n', 2,
     'per_hour is -1, but must be a number from 0 to 100000'),
    ('groups: {}\n', 1, 'the demand has no missions: give flows or csv'),
])
def test_what_is_wrong_is_one_sentence_with_its_line(yard, tmp_path, text, line, problem) -> None:
    with pytest.raises(FileError) as error:
        wanted(tmp_path, yard, text)
    assert (error.value.line, error.value.problem) == (line, problem)


def test_a_wrong_line_of_a_csv_is_named(yard, tmp_path) -> None:
    (tmp_path / 'day.csv').write_text('time,destinations\n1,21\n2,77\n')
    with pytest.raises(FileError) as error:
        wanted(tmp_path, yard, 'csv: day.csv\n')
    assert str(error.value) == f'{tmp_path}/day.csv, line 3: the graph has no vertex 77.'


# -- proposals -------------------------------------------------------------------------------------

ROOM = 1.0  # m
DOCK = 21


@pytest.fixture
def charging_yard(yard: Graph) -> Graph:
    """Returns the yard with a dock at the end of a spur."""
    return Graph([replace(vertex, dock=vertex.id == DOCK) for vertex in yard.vertices.values()],
                 list(yard.edges.values()))


def dock_proposals(graph: Graph, docks_in_use: int) -> list:
    return [one for one in proposals(graph, [1], ROOM, docks_in_use) if one.docks]


def test_another_dock_is_proposed_where_all_docks_were_in_use(charging_yard: Graph) -> None:
    assert not dock_proposals(charging_yard, 0)
    proposal, = dock_proposals(charging_yard, 1)
    added, = proposal.docks
    vertex = proposal.graph.vertices[added]
    assert vertex.dock
    assert str(added) in proposal.what, 'the text must name the dock for the fleet file'
    others = [one.position for one in charging_yard.vertices.values()]
    assert min(math.dist(vertex.position, other) for other in others) >= ROOM


def test_robots_that_charge_use_a_dock_that_is_added() -> None:
    charging = RobotType('ld90', 0.43, 1.35, docks=frozenset((DOCK,)))
    other = RobotType('agv', 0.35, 1.0)
    fleet = with_docks(Fleet((charging, other), (Robot('one', charging, 1, 'ld90'),
                                                 Robot('two', other, 2, 'agv'))), frozenset((99,)))
    assert [kind.docks for kind in fleet.types] == [frozenset((DOCK, 99)), None]
    assert [robot.type.docks for robot in fleet.robots] == [frozenset((DOCK, 99)), None]


def test_every_proposal_is_a_graph_that_can_be_saved_and_read_again(charging_yard: Graph,
                                                                    tmp_path) -> None:
    made = proposals(charging_yard, list(charging_yard.edges), ROOM, 1)
    kinds = {one.name.split('_')[0] for one in made}
    assert kinds == {'cut', 'one', 'passing', 'no', 'dock'}
    for one in made:
        assert is_kept(one, tmp_path), one.what


def is_kept(proposal: Proposal, folder) -> bool:
    save_graph(proposal.graph, folder / 'changed.yaml')
    return load_graph(folder / 'changed.yaml').is_same(proposal.graph)
