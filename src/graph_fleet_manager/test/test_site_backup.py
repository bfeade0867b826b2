"""A site is saved while it runs. After a restore, its fleet begins as with a lost journal."""
from __future__ import annotations

import io
import tarfile
from pathlib import Path

import pytest
from fleet_builders import AGV, corridor

from fleet_simulation.supervised_fleet import SupervisedFleet
from graph_fleet_manager.commands import site_backup
from graph_fleet_manager.commands.site_backup import JOURNAL, main
from graph_fleet_manager.supervision.journal import Journal, history
from graph_fleet_manager.supervision.missions import MissionState


@pytest.fixture
def home(tmp_path, monkeypatch):
    home = tmp_path / 'ros_home'
    (home / JOURNAL).parent.mkdir(parents=True)
    monkeypatch.setenv('ROS_HOME', str(home))
    (home / 'graph_fleet_manager/closed_edges.json').write_text('[3]')
    return home


@pytest.fixture
def site(tmp_path):
    folder = tmp_path / 'site'
    folder.mkdir()
    for name, mode in (('graph.yaml', 0o644), ('tokens', 0o600)):
        (folder / name).write_text(name)
        (folder / name).chmod(mode)
    return folder


def save(tmp_path, site) -> str:
    archive = str(tmp_path / 'backup.tar.gz')
    assert main(['save', archive, *map(str, site.iterdir())]) == 0
    return archive


def test_a_journal_of_before_is_as_good_as_lost_and_its_history_is_kept(
        tmp_path, monkeypatch, site, capsys):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    home = Path(fleet.journal._path).parent
    monkeypatch.setenv('ROS_HOME', str(home))
    monkeypatch.setattr(site_backup, 'DATABASES', ('journal.sqlite',))
    monkeypatch.setattr(site_backup, 'JOURNAL', 'journal.sqlite')
    fleet.request(1, 3)
    fleet.run_until_done(1)
    fleet.request(2, 8)
    fleet.run(2.0)
    archive = save(tmp_path, site)
    fleet.run_until_done(2)
    fleet.request(3, 1)
    fleet.run(4.0)
    assert fleet.agvs['a'].is_driving
    fleet.journal.close()
    monkeypatch.setattr(fleet.journal, 'close', lambda: None)
    assert main(['restore', archive, str(tmp_path / 'elsewhere')]) == 0
    assert '1 open missions are CANCELLED' in capsys.readouterr().out
    assert [(line.request_id, line.state) for line in history(str(home / 'journal.sqlite'))] == [
        (1, MissionState.SUCCEEDED), (2, MissionState.CANCELLED)]
    fleet.restart()
    fleet.run(10.0)
    assert any('the journal does not know' in note for note in fleet.notes)
    fleet.request(4, 2)
    fleet.run_until_done(4)
    assert fleet.state(4) is MissionState.SUCCEEDED


def test_secrets_are_kept_apart_and_come_back_for_their_owner_only(tmp_path, home, site):
    archive = save(tmp_path, site)
    secrets = tmp_path / 'backup.secrets.tar.gz'
    assert secrets.stat().st_mode & 0o777 == 0o600
    with tarfile.open(archive) as public:
        assert 'site/graph.yaml' in public.getnames() and 'site/tokens' not in public.getnames()
    there = tmp_path / 'there'
    for one in (archive, str(secrets)):
        assert main(['restore', one, str(there)]) == 0
    assert (there / 'graph.yaml').read_text() == 'graph.yaml'
    assert (there / 'tokens').stat().st_mode & 0o777 == 0o600


def test_a_fleet_manager_that_runs_keeps_its_journal(tmp_path, home, site, capsys):
    running = Journal(str(home / JOURNAL))
    archive = save(tmp_path, site)
    assert main(['restore', archive, str(tmp_path / 'there')]) == 1
    assert 'another path_supervisor uses it' in capsys.readouterr().err
    assert not (tmp_path / 'there').exists()
    running.close()


@pytest.mark.parametrize('name', ['../evil', 'site/../evil', 'ros_home/fleet_page/evil', '/evil',
                                  'site/..'])
def test_an_archive_of_others_writes_nothing(tmp_path, home, name):
    archive = tmp_path / 'evil.tar.gz'
    with tarfile.open(archive, 'w:gz') as evil:
        evil.addfile(tarfile.TarInfo(name), io.BytesIO())
    assert main(['restore', str(archive), str(tmp_path / 'there')]) == 1
    assert not (tmp_path / 'there').exists() and not (tmp_path / 'evil').exists()


def test_closed_edges_come_back(tmp_path, home, site):
    archive = save(tmp_path, site)
    (home / 'graph_fleet_manager/closed_edges.json').write_text('[]')
    assert main(['restore', archive, str(site)]) == 0
    assert (home / 'graph_fleet_manager/closed_edges.json').read_text() == '[3]'


@pytest.mark.parametrize('words', [[], ['save'], ['restore', 'x'], ['delete', 'x']])
def test_what_it_does_not_know_it_does_not_do(words, home):
    assert main(words) == 1
