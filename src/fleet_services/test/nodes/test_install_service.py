"""A site is installed below a folder, and removed again. These tests need a ROS workspace."""
from __future__ import annotations

import os
import shutil
import stat
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Iterable, Iterator, List

import pytest

pytest.importorskip('rospkg')
from file_modes import differences, walk

from fleet_services import command, installation
from fleet_services.command import main

TOKENS = 'see anna 0123456789abcdef0123456789abcdef\n'
FINISHED_MAP = Path(__file__).resolve().parents[4] / 'maps' / 'lab.map'


def make_site(folder: Path, map_file: str = '') -> Path:
    """Makes the files of a site. Without `map_file`, the installation makes the map, which takes
    some s.
    """
    (folder / 'tokens').write_text(TOKENS)
    (folder / 'tokens').chmod(0o600)
    write_site(folder, f'fleet: 2, token_file: tokens, map_file: "{map_file}"')
    return folder


def write_site(folder: Path, arguments: str, name: str = 'hall', robots_per_unit: int = 1) -> None:
    (folder / 'site.yaml').write_text(
        f'name: {name}\nrobots_per_unit: {robots_per_unit}\narguments: {{{arguments}}}\n')


@pytest.fixture
def site() -> Iterator[Path]:
    """Returns a site in a folder that all users can enter."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        yield make_site(Path(folder), str(FINISHED_MAP))


@pytest.fixture(scope='module')
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns the folder below which a site is installed."""
    return install(make_site(tmp_path_factory.mktemp('site')))


@pytest.fixture
def installed(site: Path, root: Path) -> Path:
    """Returns a copy of the folder below which `site` is installed, for a test that changes it."""
    return Path(shutil.copytree(root, site / 'root', symlinks=True))


@pytest.fixture(autouse=True, scope='module')
def systemd() -> Iterator[None]:
    """Makes every machine seem to have the version of systemd that Debian 12 has."""
    before = command.systemd_version
    command.systemd_version = lambda: 252
    yield
    command.systemd_version = before


def install(site: Path) -> Path:
    root = site / 'root'
    assert main(['--root', str(root), str(site / 'site.yaml')]) == 0
    return root


def test_each_unit_has_its_launch_file_and_no_path_names_the_root(root):
    units = {unit.name for unit in (root / 'etc/systemd/system').iterdir()}
    assert units == {'fleet-hall.target', *(f'fleet-hall-{name}.service' for name in (
        'master', 'simulators', 'robots-1', 'robots-2', 'manager', 'page'))}
    for file in root.rglob('*'):
        if file.is_file():
            assert str(root) not in file.read_text(errors='replace'), file


def test_the_watch_of_a_unit_knows_the_nodes_that_tell_how_they_are(root):
    launch = ET.parse(root / 'etc/fleet/hall/manager.launch').getroot()
    watch = next(node for node in launch.findall('node') if node.get('type') == 'service_watch')
    nodes = watch.find('param').get('value').split()
    assert {'/graph_server', '/path_planner', '/path_supervisor'} <= set(nodes)
    assert not [name for name in nodes if 'node_host' in name]


def test_a_secret_is_for_its_owner_only_and_stands_in_no_other_file(root):
    kept = root / 'etc/fleet/hall/secrets/token_file'
    assert kept.read_text() == TOKENS
    assert stat.S_IMODE(kept.stat().st_mode) == 0o600
    assert [file for file in root.rglob('*') if file.is_file() and file != kept
            and TOKENS.split()[-1] in file.read_text(errors='replace')] == []


def test_a_unit_that_a_changed_site_lacks_goes(site, installed):
    write_site(site, f'fleet: 1, page: false, map_file: {FINISHED_MAP}')
    install(site)
    assert {unit.name for unit in (installed / 'etc/systemd/system').glob('*.service')} == {
        f'fleet-hall-{name}.service' for name in ('master', 'simulators', 'robots-1', 'manager')}
    assert not (installed / 'etc/fleet/hall/secrets').exists()


def test_remove_leaves_the_data_and_purge_does_not(site, installed, capsys):
    root = installed
    write_site(site, f'fleet: 1, map_file: {FINISHED_MAP}', 'hall-2')
    install(site)
    journal = root / 'var/lib/fleet/hall/graph_fleet_manager/fleet.sqlite'
    journal.parent.mkdir(parents=True)
    journal.write_text('missions')
    assert main(['--root', str(root), '--remove', 'hall']) == 0
    assert journal.exists()
    assert not (root / 'etc/fleet/hall').exists()
    assert {unit.name.split('.')[0] for unit in (root / 'etc/systemd/system').iterdir()} == {
        'fleet-hall-2', *(f'fleet-hall-2-{name}' for name in (
            'master', 'simulators', 'robots-1', 'manager', 'page'))}
    assert main(['--root', str(root), '--purge', 'hall']) == 0
    assert not journal.exists()
    assert main(['--root', str(root), '--remove', 'hall']) == 1
    assert 'There is no site hall' in capsys.readouterr().err


def test_a_site_that_cannot_be_made_anew_keeps_its_files(site, installed, capsys):
    root = installed
    before = {file: file.read_bytes() for file in root.rglob('*') if file.is_file()}
    (site / 'tokens').unlink()
    assert main(['--root', str(root), str(site / 'site.yaml')]) == 1
    assert 'tokens' in capsys.readouterr().err
    assert {file: file.read_bytes() for file in root.rglob('*') if file.is_file()} == before
    assert [folder.name for folder in (root / 'etc/fleet').iterdir()] == ['hall']


@pytest.mark.parametrize('name', ['..', '', '../hall', 'hall/..', '/etc', '*'])
def test_only_the_name_of_a_site_is_removed(root, capsys, name):
    before = set(root.rglob('*'))
    for option in ('--remove', '--purge'):
        assert main(['--root', str(root), option, name]) == 1
        assert 'must begin with a small letter' in capsys.readouterr().err
    assert set(root.rglob('*')) == before


SERVICE = 61234  # user id of the services in an image


@pytest.fixture
def image(site: Path) -> Path:
    """Returns the root folder of an image that has the user of the services."""
    if os.geteuid() != 0:
        pytest.skip('only root can give files to the user of the services')
    root = site / 'root'
    (root / 'etc').mkdir(parents=True)
    for name in ('passwd', 'group'):
        (root / 'etc' / name).write_text(f'root:x:0:0::/:\nfleet:x:{SERVICE}:{SERVICE}::/:\n')
    return root


def different(image: Path) -> List[str]:
    """Returns how the files of the site differ from the table in docs/explanation/security.md."""
    names = {0: 'root', SERVICE: 'services'}
    return differences(one for folder in ('etc/fleet', 'var/lib/fleet', 'var/log/fleet',
                                          'etc/systemd/system')
                       for one in walk(image / folder, f'/{folder}', names))


def test_the_files_of_a_site_are_those_of_the_table(site, image):
    before = os.umask(0)
    try:
        install(site)
    finally:
        os.umask(before)
    assert different(image) == []


def test_an_older_systemd_lets_the_services_read_their_secrets_themselves(
        site, image, monkeypatch):
    monkeypatch.setattr(command, 'systemd_version', lambda: 245)
    install(site)
    assert different(image) == [
        '/etc/fleet/hall/secrets is 0750 of root:services, but must be 0700 of root:root',
        '/etc/fleet/hall/secrets/token_file is 0600 of services:services, but must be 0600 of '
        'root:root']


STATE = {'graph_fleet_manager/fleet.sqlite': 'manager', 'graph_fleet_manager/fleet.sqlite-wal':
         'manager', 'graph_fleet_manager/closed_edges.json': 'manager',
         'fleet_page/page.sqlite': 'page', 'fleet_page/replay/1': 'page',
         'omron_ld90/ld90_1_motion.json': 'robots-1', 'omron_ld90/ld90_1_route.json': 'robots-1',
         'omron_ld90/ld90_2_route.json': 'robots-2',
         'omron_ld90/ld90_2_route.json.lock': 'robots-2',
         'roscore-11311.pid': 'master', 'roscore-11312.pid': 'master'}
"""The unit to which each persistent file belongs."""


def make_site_of_1_0_0(image: Path, files: Iterable[str] = (*STATE, 'notes')) -> Path:
    """Makes the state of a site of version 1.0.0: one folder, which all units shared."""
    home = image / 'var/lib/fleet/hall'
    for name in files:
        (home / name).parent.mkdir(parents=True, exist_ok=True)
        (home / name).write_text(name)
    for path in (home, *home.rglob('*')):
        path.chmod(0o700 if path.is_dir() else 0o600)  # the units of 1.0.0 had the umask 077
        os.chown(path, SERVICE, SERVICE)
    return home


def make_logs_of_1_0_0(image: Path, unit: str) -> Path:
    """Makes the logs of a unit of version 1.0.0: systemd made their folder with mode 0755, and ROS
    gave each folder the mode of the folder above it.
    """
    logs = image / 'var/log/fleet/hall' / unit
    (logs / 'run' / 'node').mkdir(parents=True)
    (logs / 'run' / 'node' / 'node.log').write_text('a line')
    (logs / 'latest').symlink_to('run')
    for path in (logs, *logs.rglob('*')):
        if not path.is_symlink():
            path.chmod(0o755 if path.is_dir() else 0o644)
        os.chown(path, SERVICE, SERVICE, follow_symlinks=False)
    return logs


def test_a_site_of_1_0_0_loses_no_file(site, image, capsys):
    home = make_site_of_1_0_0(image)
    logs = [make_logs_of_1_0_0(image, unit) for unit in ('manager', 'a-unit-that-is-no-more')]
    install(site)
    for name, unit in STATE.items():
        assert (home / unit / name).read_text() == name
    assert (home / 'notes').read_text() == 'notes'
    assert f'Moved {home}/graph_fleet_manager to' in capsys.readouterr().out
    assert all((log / 'run/node/node.log').read_text() == 'a line' for log in logs)
    (home / 'notes').unlink()
    assert different(image) == []


def test_a_robot_that_gets_another_unit_takes_its_files_along(site, image):
    home = make_site_of_1_0_0(image)
    install(site)
    write_site(site, f'fleet: 2, token_file: tokens, map_file: {FINISHED_MAP}',
               robots_per_unit=2)
    install(site)
    names = {name: 'robots-1' if unit == 'robots-2' else unit for name, unit in STATE.items()}
    assert [name for name, unit in names.items() if not (home / unit / name).is_file()] == []


def test_state_that_is_there_twice_is_left_to_a_person(site, image, capsys):
    home = make_site_of_1_0_0(image, ['graph_fleet_manager/fleet.sqlite',
                                      'manager/graph_fleet_manager/fleet.sqlite'])
    before = {path: path.lstat().st_uid for path in home.rglob('*')}
    assert main(['--root', str(image), str(site / 'site.yaml')]) == 1
    assert 'remove the older one' in capsys.readouterr().err
    assert {path: path.lstat().st_uid for path in home.rglob('*')} == before
    assert not (image / 'etc/fleet/hall').exists()


@pytest.mark.parametrize('name', ['omron_ld90', 'manager', 'page'])
def test_root_moves_nothing_through_a_link_of_a_service(site, image, name):
    closed = site / 'closed'
    closed.mkdir(mode=0o700)
    (closed / 'ld90_1_route.json').write_text('of root')
    home = make_site_of_1_0_0(image, ['graph_fleet_manager/fleet.sqlite',
                                      'fleet_page/page.sqlite'])
    (home / name).symlink_to(closed)
    os.chown(home / name, SERVICE, SERVICE, follow_symlinks=False)
    main(['--root', str(image), str(site / 'site.yaml')])
    assert [file.name for file in closed.iterdir()] == ['ld90_1_route.json']
    assert closed.stat().st_uid == 0


def test_root_gives_nothing_another_mode_through_a_link_of_a_service(site, image):
    logs = make_logs_of_1_0_0(image, 'manager')
    home = make_site_of_1_0_0(image, ['manager/graph_fleet_manager/fleet.sqlite'])
    of_root, own = site / 'of_root', site / 'own'
    for file in (of_root, own):
        file.write_text('')
        file.chmod(0o644)
    os.chown(own, SERVICE, SERVICE)
    for folder in (logs, home / 'manager'):
        for target in (of_root, own, site):
            (folder / target.name).symlink_to(target)
    install(site)
    assert [stat.S_IMODE(path.stat().st_mode) for path in (of_root, own, site)] == [
        0o644, 0o644, 0o755]


@pytest.mark.parametrize('what', ['file', 'folder', 'link', 'open folder'])
def test_root_reads_no_file_that_the_services_could_replace(site, what):
    map_file = site / 'maps' / 'site.map'
    map_file.parent.mkdir()
    map_file.write_text('2D-Map')
    installation.refuse_replaceable([map_file], SERVICE)
    if what == 'link':
        map_file.unlink()
        map_file.symlink_to('/etc/shadow')
        os.chown(map_file, SERVICE, -1, follow_symlinks=False)
    elif what == 'open folder':
        map_file.parent.chmod(0o777)
    else:
        os.chown(map_file if what == 'file' else map_file.parent, SERVICE, -1)
    with pytest.raises(installation.NotInstalled, match='can replace'):
        installation.refuse_replaceable([map_file], SERVICE)


def test_a_unit_imports_only_what_root_has_installed(site, monkeypatch):
    for name in ('PYTHONPATH', 'PATH', 'LD_LIBRARY_PATH'):
        monkeypatch.setenv(name, f':.:{os.environ.get(name, "")}::here:')
    environment = dict(line.split('=', 1) for line in (
        install(site) / 'etc/fleet/hall/environment').read_text().splitlines())
    assert environment['PYTHONNOUSERSITE'] == environment['PYTHONSAFEPATH'] == '"1"'
    for name in ('PYTHONPATH', 'PATH', 'LD_LIBRARY_PATH', 'ROS_PACKAGE_PATH'):
        folders = environment.get(name, '""').strip('"')
        assert [one for one in folders.split(':') if folders and not one.startswith('/')] == []


def test_the_units_start_the_master_that_refuses_browsers_also_without_the_setup_file(
        site, monkeypatch):
    roslaunch = shutil.which('roslaunch')
    monkeypatch.setenv('PATH', f'{Path(roslaunch).parent}:/usr/bin:/bin')
    environment = dict(line.split('=', 1) for line in (
        install(site) / 'etc/fleet/hall/environment').read_text().splitlines())
    master = shutil.which('rosmaster', path=environment['PATH'].strip('"'))
    assert 'node_lifecycle' in Path(master).parts
    assert shutil.which('rosmaster') != master


def test_a_wrong_site_file_is_one_sentence_and_writes_nothing(site, capsys):
    (site / 'site.yaml').write_text('name: hall\n')
    assert main(['--root', str(site / 'root'), str(site / 'site.yaml')]) == 1
    assert capsys.readouterr().err.count('\n') == 1
    assert not (site / 'root').exists()
