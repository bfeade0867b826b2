"""A site below a folder: the installed files and their removal; needs a ROS workspace."""
from __future__ import annotations

import os
import stat
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

pytest.importorskip('rospkg')

from fleet_services.command import main  # noqa: E402

TOKENS = 'see anna 0123456789abcdef0123456789abcdef\n'


def make_site(folder: Path) -> Path:
    (folder / 'tokens').write_text(TOKENS)
    (folder / 'tokens').chmod(0o600)
    (folder / 'site.yaml').write_text(
        'name: hall\nrobots_per_unit: 1\narguments: {fleet: 2, token_file: tokens}\n')
    return folder


@pytest.fixture
def site(tmp_path: Path) -> Path:
    return make_site(tmp_path)


@pytest.fixture(scope='module')
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder below which a site is installed."""
    return install(make_site(tmp_path_factory.mktemp('site')))


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


def test_a_unit_that_a_changed_site_lacks_goes(site):
    root = install(site)
    (site / 'site.yaml').write_text('name: hall\narguments: {fleet: 1, page: false}\n')
    install(site)
    assert {unit.name for unit in (root / 'etc/systemd/system').glob('*.service')} == {
        f'fleet-hall-{name}.service' for name in ('master', 'simulators', 'robots-1', 'manager')}
    assert not (root / 'etc/fleet/hall/secrets').exists()


def test_remove_leaves_the_data_and_purge_does_not(site, capsys):
    root = install(site)
    (site / 'site.yaml').write_text('name: hall-2\narguments: {fleet: 1}\n')
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


def test_a_site_that_cannot_be_made_anew_keeps_its_files(site, capsys):
    root = install(site)
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


def test_the_user_of_the_services_can_read_what_is_no_secret(site):
    before = os.umask(0o077)
    try:
        root = install(site)
    finally:
        os.umask(before)
    closed = [path for path in root.rglob('*') if path.parent.name != 'secrets'
              and path.name != 'secrets' and not stat.S_IMODE(path.stat().st_mode) & 0o004]
    assert closed == []


def test_a_wrong_site_file_is_one_sentence_and_writes_nothing(site, capsys):
    (site / 'site.yaml').write_text('name: hall\n')
    assert main(['--root', str(site / 'root'), str(site / 'site.yaml')]) == 1
    assert capsys.readouterr().err.count('\n') == 1
    assert not (site / 'root').exists()
