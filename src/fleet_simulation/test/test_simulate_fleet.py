import csv
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Callable, Dict, List

import pytest

from fleet_core.files.fleet_file import load_fleet
from fleet_core.files.robot_settings import load_settings
from fleet_simulation.command import main
from fleet_simulation.demand_file import load_demand
from fleet_simulation.figures import Figures, Use
from fleet_simulation.simulation import simulate
from fleet_simulation.site import Site, site_of
from trajectory_graph import Graph, load_graph

Files = Callable[..., Dict[str, str]]
SATURATED = 'groups: {all: [21, 22, 23, 24, 25]}\nflows:\n- {to: all, saturated: 1.0}\n'


def site(yard: Graph, paths: Dict[str, str]) -> Site:
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
    for _ in range(2):  # a report of before is replaced
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
