"""This version restores the backup of a site of 1.0.0, and reads each of its files.

test/vectors/release_1_0_0 has files that the code of 1.0.0 wrote: graph, graph in force, closed
edges, and dumps of the journal and of the page's records. It also has a fleet file and a site file
that version 1.0.0 accepted. `archive` packs all files like the backup command of 1.0.0.
test_journal.py tests a journal of 1.0.0 on the disk, with an open mission.
"""
from __future__ import annotations

import sqlite3
import tarfile
from contextlib import closing
from pathlib import Path

import pytest

from fleet_core.files.fleet_file import load_fleet
from fleet_core.site.closures import Closures
from fleet_core.site.graph_in_force import GraphInForce
from fleet_core.supervision.history import history
from fleet_core.supervision.journal import Journal
from fleet_core.supervision.missions import MissionState
from fleet_page.core.records import NamedKind, Records, Sums
from fleet_services.backup import JOURNAL, main
from fleet_services.site_file import read_site
from trajectory_graph import load_graph

ROOT = Path(__file__).resolve().parents[3]
FILES = ROOT / 'test/vectors/release_1_0_0'
DATABASES = {JOURNAL: ROOT / 'src/fleet_simulation/test/supervision/journal_1_0_0.sql',
             'fleet_page/page.sqlite': FILES / 'ros_home/fleet_page/page.sql'}


@pytest.fixture
def archive(tmp_path) -> Path:
    """Makes a backup of 1.0.0, with the path and mode of each file."""
    path = tmp_path / 'backup.tar.gz'
    with tarfile.open(path, 'w:gz') as target:
        for file in sorted(FILES.rglob('*/*')):
            if file.suffix in ('.yaml', '.json'):
                target.add(str(file), str(file.relative_to(FILES)))
        for name, dump in DATABASES.items():
            copy = tmp_path / name.replace('/', '_')
            with closing(sqlite3.connect(copy)) as database:
                database.executescript(dump.read_text(encoding='utf-8'))
            target.add(str(copy), f'ros_home/{name}')
    return path


@pytest.fixture
def home(tmp_path, monkeypatch, archive) -> Path:
    """Returns the restored ROS_HOME; the files of the site are in the folder `site` beside it."""
    home = tmp_path / 'home'
    home.mkdir()
    (tmp_path / 'site').mkdir()
    monkeypatch.setenv('ROS_HOME', str(home))
    assert main(['restore', str(archive), str(tmp_path / 'site')]) == 0
    return home


def test_the_graph_and_the_fleet_of_1_0_0_are_those_of_the_site(home):
    site = home.parent / 'site'
    graph, fleet = load_graph(site / 'graph.yaml'), load_fleet(site / 'fleet.yaml')
    assert (len(graph.vertices), set(graph.edges)) == (8, set(range(1, 8)))
    assert [(robot.name, robot.type.name, robot.vertex, robot.absent)
            for robot in fleet.robots] == [
        ('a', 'agv', 2, False), ('b', 'agv', 8, False), ('ld90_1', 'omron_ld90', 1, True)]
    assert [(one.reach, one.docks) for one in fleet.types] == [
        (0.4, None), (0.43 + 0.25, frozenset({1}))]
    assert 'stopping: 3.5' in (site / 'fleet.yaml').read_text()  # this version ignores the key


def test_the_site_file_of_1_0_0_is_read(home):
    site = read_site(str(home.parent / 'site/site.yaml'))
    assert (site.name, site.user, site.networks) == ('hall', 'fleet', ())


def test_closed_edges_of_1_0_0_stay_closed(home):
    assert Closures(home / 'graph_fleet_manager/closed_edges.json').edges == {6}


def test_the_graph_in_force_of_1_0_0_is_known_after_the_update(home):
    """If the graph file has changed since then, the first start waits for the robots' reports."""
    file, kept = home.parent / 'site/graph.yaml', home / 'graph_fleet_manager/graph_in_force.yaml'
    kept.write_text(kept.read_text().replace('/tmp/hall', str(file.parent)))
    assert not GraphInForce(str(kept)).must_hear_robots(str(file))
    file.write_text(file.read_text().replace('VelocityForward: 1.0', 'VelocityForward: 0.5'))
    assert GraphInForce(str(kept)).must_hear_robots(str(file))


def test_the_history_of_missions_of_1_0_0_is_kept(home):
    journal = Journal(str(home / JOURNAL))
    assert [mission.state for mission in journal.missions()] == [
        MissionState.CANCELLED, MissionState.SUCCEEDED]
    assert (journal.robots(), journal.last_serial()) == ({}, 2)
    journal.close()
    assert [(line.request_id, line.state) for line in history(str(home / JOURNAL))] == [
        (7, MissionState.CANCELLED), (8, MissionState.SUCCEEDED)]


def test_the_records_of_the_page_of_1_0_0_are_kept_and_go_on(home):
    records = Records(str(home / 'fleet_page/page.sqlite'))
    row, = records.audit(10)
    assert (row['person'], row['act'], row['outcome']) == ('anna', 'send', 'accepted')
    assert records.named(NamedKind.FAVOURITE) == {'both ends': {'destinations': [1, 8]}}
    assert records.robot_sums(0.0) == {'a': Sums(2.0, 4.0, 1.0, 5.0)}
    records.keep_named(NamedKind.AREA, 'aisle', {'edges': [2, 3]})
    assert records.named(NamedKind.AREA) == {'aisle': {'edges': [2, 3]}}
    records.close()
