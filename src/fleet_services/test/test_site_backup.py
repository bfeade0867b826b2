"""A site is saved while it runs. After a restore, its fleet begins as if the journal were lost."""
from __future__ import annotations

import io
import os
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import pytest
from file_modes import differences, walk

from fleet_core.fleet import RobotType
from fleet_core.supervision.history import history
from fleet_core.supervision.journal import Journal
from fleet_core.supervision.missions import MissionState
from fleet_services import backup
from fleet_services.backup import JOURNAL, main
from fleet_services.file_kinds import is_secret
from trajectory_graph import Edge, Graph, Vertex
from world.supervised_fleet import SupervisedFleet

TEXT = 'graph_fleet_manager/closed_edges.json'
GRAPH = 'Vertices: []\nEdges: []\n'
TOKENS = 'see anna 0123456789abcdef0123456789abcdef\n'
SERVICE = 61234  # id of a user that no system has


def corridor(length: int) -> Graph:
    """Returns a graph with the vertices 1 .. length in a row, 2 m apart."""
    return Graph([Vertex(k, 2.0 * k, 0.0, 0.0) for k in range(1, length + 1)],
                 [Edge(k, k, k + 1, velocity_forward=1.0, velocity_backwards=1.0)
                  for k in range(1, length)])


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
    for name, mode, text in (('graph.yaml', 0o644, GRAPH), ('tokens', 0o644, TOKENS),
                             ('site.map', 0o600, '2D-Map\n')):
        (folder / name).write_text(text)
        (folder / name).chmod(mode)
    return folder


def save(tmp_path, site) -> str:
    archive = str(tmp_path / 'backup.tar.gz')
    assert main(['save', archive, *map(str, site.iterdir())]) == 0
    return archive


def test_a_journal_of_before_is_as_good_as_lost_and_its_history_is_kept(
        tmp_path, monkeypatch, site, capsys):
    fleet = SupervisedFleet(corridor(8), {'a': (RobotType('agv', 0.4, 1.0), 1)})
    home = Path(fleet.disk.journal._path).parent
    monkeypatch.setenv('ROS_HOME', str(home))
    monkeypatch.setattr(backup, 'DATABASES', ('journal.sqlite',))
    monkeypatch.setattr(backup, 'JOURNAL', 'journal.sqlite')
    fleet.request(1, 3)
    fleet.run_until_done(1)
    fleet.request(2, 8)
    fleet.run(2.0)
    archive = save(tmp_path, site)
    fleet.run_until_done(2)
    fleet.request(3, 1)
    fleet.run(4.0)
    assert fleet.agvs['a'].is_driving
    fleet.disk.journal.close()
    monkeypatch.setattr(fleet.disk.journal, 'close', lambda: None)
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
        assert {'site/graph.yaml', 'site/site.map'} <= set(public.getnames())
        assert 'site/tokens' not in public.getnames()
    there = tmp_path / 'there'
    for one in (archive, str(secrets)):
        assert main(['restore', one, str(there)]) == 0
    assert (there / 'graph.yaml').read_text() == GRAPH
    assert (there / 'tokens').read_text() == TOKENS


@pytest.mark.parametrize('theirs', [b'a holiday picture', None])
def test_secrets_replace_no_file_that_another_program_wrote(tmp_path, home, site, capsys, theirs):
    place = tmp_path / 'backup.secrets.tar.gz'
    if theirs is None:
        with tarfile.open(place, 'w:gz') as archive:
            archive.add(str(site / 'graph.yaml'), 'graph.yaml')
        theirs = place.read_bytes()
    place.write_bytes(theirs)
    words = ['save', str(tmp_path / 'backup.tar.gz'), str(site / 'tokens')]
    assert main(words) == 1
    assert str(place) in capsys.readouterr().err and place.read_bytes() == theirs
    assert not (tmp_path / 'backup.tar.gz').exists(), 'all is saved, or nothing'
    place.unlink()
    assert main(words) == 0 == main(words), 'its own archive is replaced'


def test_archives_and_what_comes_back_are_for_their_owner_only(tmp_path, home, site):
    archive = save(tmp_path, site)
    there = tmp_path / 'there'
    for one in (archive, str(tmp_path / 'backup.secrets.tar.gz')):
        assert main(['restore', one, str(there)]) == 0
    names = {os.geteuid(): 'user', os.getegid(): 'user'}
    archives = [one for one in walk(tmp_path, 'BACKUP', names) if one[0].endswith('.tar.gz')]
    restored = list(walk(there, 'RESTORED', names))
    assert (len(archives), len(restored)) == (2, 3)
    assert differences([*archives, *restored]) == []
    assert (home / TEXT).stat().st_mode & 0o777 == 0o600
    assert there.stat().st_mode & 0o777 == 0o700


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


@pytest.fixture
def foreign(monkeypatch):
    """Yields a folder that all users can enter, with the state of services of another user."""
    if os.geteuid() != 0:
        pytest.skip('only root can work for another user')
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        state = folder / 'state'
        (state / 'graph_fleet_manager').mkdir(parents=True)
        for path in (state, state / 'graph_fleet_manager'):
            os.chown(path, SERVICE, SERVICE)
        (folder / 'root_only').write_text('secret of root')
        (folder / 'root_only').chmod(0o600)
        (folder / 'closed').mkdir(mode=0o700)
        monkeypatch.setenv('ROS_HOME', str(state))
        yield folder


def plant(link: Path, target: Path) -> None:
    """Makes a link of the services' user."""
    link.symlink_to(target)
    os.chown(link, SERVICE, SERVICE, follow_symlinks=False)


@pytest.mark.parametrize('name', [JOURNAL, 'graph_fleet_manager/closed_edges.json',
                                  'graph_fleet_manager/graph_in_force.yaml'])
def test_root_saves_no_file_of_root_to_which_a_service_has_a_link(tmp_path, foreign, name):
    plant(foreign / 'state' / name, foreign / 'root_only')
    main(['save', str(tmp_path / 'a.tar.gz')])
    assert not contains(tmp_path, b'secret of root')


def test_root_saves_no_file_of_root_to_which_a_given_file_is_a_link_of_another(tmp_path, foreign):
    plant(foreign / 'graph.yaml', foreign / 'root_only')
    assert main(['save', str(tmp_path / 'a.tar.gz'), str(foreign / 'graph.yaml')]) == 1
    assert not contains(tmp_path, b'secret of root')


def test_root_restores_nothing_into_a_folder_of_root_to_which_a_service_has_a_link(
        tmp_path, foreign):
    state = foreign / 'state'
    (state / TEXT).write_text('[3]')
    archive = str(tmp_path / 'a.tar.gz')
    assert main(['save', archive]) == 0
    (state / TEXT).unlink()
    (state / 'graph_fleet_manager').rmdir()
    plant(state / 'graph_fleet_manager', foreign / 'closed')
    assert main(['restore', archive, str(tmp_path)]) == 1
    assert list((foreign / 'closed').iterdir()) == []


def test_restored_state_belongs_to_the_user_of_the_services(tmp_path, foreign):
    place = foreign / 'state' / TEXT
    place.write_text('[3]')
    archive = str(tmp_path / 'a.tar.gz')
    assert main(['save', archive]) == 0
    place.unlink()
    assert main(['restore', archive, str(tmp_path)]) == 0
    assert (place.stat().st_uid, place.stat().st_mode & 0o777) == (SERVICE, 0o600)


def test_secrets_are_not_written_into_a_folder_of_the_services(tmp_path, foreign, site, capsys):
    archive = foreign / 'state' / 'a.tar.gz'
    assert main(['save', str(archive), *map(str, site.iterdir())]) == 1
    assert 'choose another folder' in capsys.readouterr().err
    assert not archive.exists()


def contains(folder: Path, content: bytes) -> bool:
    """Returns whether an archive in the folder contains a file with this content."""
    for archive in folder.glob('*.tar.gz'):
        with tarfile.open(archive) as source:
            if any(content in source.extractfile(member).read() for member in source.getmembers()):
                return True
    return False


def test_the_command_imports_nothing_from_where_it_is_called(tmp_path):
    """The command imports nothing from the working directory, PYTHONPATH, or the user's folder."""
    user_site = tmp_path / '.local/lib' / f'python3.{sys.version_info.minor}' / 'site-packages'
    user_site.mkdir(parents=True)
    mark = tmp_path / 'imported'
    for folder in (tmp_path, user_site):
        for module in ('yaml', 'usercustomize', 'sitecustomize', 'tarfile'):
            (folder / f'{module}.py').write_text(f"open({str(mark)!r}, 'w')\n")
    script = Path(__file__).resolve().parents[3] / 'scripts/backup.sh'
    for path in (':', str(tmp_path), ''):
        done = subprocess.run([str(script), '--help'], cwd=tmp_path, check=False, text=True, env={
            'PATH': os.environ['PATH'], 'HOME': str(tmp_path), 'PYTHONPATH': path},
            capture_output=True)
        assert (done.returncode, done.stderr) == (0, '')
        assert not mark.exists(), path


@pytest.mark.parametrize(('content', 'secret'), [
    (GRAPH, False), ('2D-Map\nMinPos: 0 0\n', False), ('robot_types: []\nrobots: []\n', False),
    ('name: hall\narguments: {fleet: 2, token_file: tokens}\n', False),
    ('image: a.pgm\nresolution: 0.05\n', False), ('-----BEGIN CERTIFICATE-----\nMII', False),
    (TOKENS, True), ('adept', True), ('username: a\npassword: b\n', True), ('', True),
    ('-----BEGIN CERTIFICATE-----\nMII\n-----BEGIN RSA PRIVATE KEY-----', True),
    ('Vertices: []\nEdges: []\npassword: b\n', True), ('a: [', True), ('\0\1', True)])
def test_a_secret_is_known_by_its_content(content, secret):
    assert is_secret(content.encode()) is secret
