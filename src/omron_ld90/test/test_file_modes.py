"""The table of files in docs/explanation/security.md is compared strictly with the files."""
from __future__ import annotations

import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / 'test'))

from file_modes import differences, rows  # noqa: E402

FILE, FOLDER = stat.S_IFREG, stat.S_IFDIR


@pytest.mark.parametrize(('path', 'mode', 'owner'), [
    ('/etc/fleet/hall/environment', FILE | 0o640, 'root:services'),
    ('/etc/fleet/hall/secrets', FOLDER | 0o700, 'root:root'),
    ('/etc/fleet/hall/secrets/tokens', FILE | 0o600, 'root:root'),
    ('/var/lib/fleet/hall/page', FOLDER | 0o700, 'services:services'),
    ('/var/lib/fleet/hall/page/fleet_page/page.sqlite', FILE | 0o600, 'services:services'),
    ('/var/lib/fleet/hall/page/fleet_page', FOLDER | 0o700, 'services:services'),
    ('PACKAGE/usr/bin/ld_map', FILE | 0o755, 'root:root')])
def test_each_file_has_one_owner_and_one_mode(path, mode, owner):
    assert differences([(path, mode, *owner.split(':'))]) == []
    assert differences([(path, mode ^ 0o004, *owner.split(':'))]) != []
    assert differences([(path, mode, 'other', owner.split(':')[1])]) != []


def test_a_file_that_is_in_no_row_is_told():
    assert differences([('/etc/other', FILE | 0o644, 'root', 'root')]) == [
        '/etc/other is in no row of the table']


def test_no_file_but_those_of_a_package_and_units_is_readable_by_all():
    assert {row.pattern for row in rows() if (row.mode | row.other) & 0o007} == {
        'PACKAGE/**', '/etc/systemd/system/fleet-*', '/var/log/fleet/*'}


@pytest.mark.skipif(shutil.which('dpkg-deb') is None, reason='dpkg-deb is not installed')
@pytest.mark.parametrize(('mode', 'status'), [(0o644, 0), (0o755, 0), (0o666, 1), (0o600, 1)])
def test_a_package_with_other_modes_is_refused(tmp_path, mode, status):
    content = tmp_path / 'content'
    for folder in (content, content / 'DEBIAN', content / 'usr'):
        folder.mkdir(mode=0o755)
    (content / 'DEBIAN' / 'control').write_text(
        'Package: a\nVersion: 1\nArchitecture: all\nMaintainer: a <a@a.invalid>\nDescription: a\n')
    (content / 'usr' / 'file').write_text('')
    (content / 'usr' / 'file').chmod(mode)
    package = tmp_path / 'a.deb'
    subprocess.run(['dpkg-deb', '--root-owner-group', '--build', str(content), str(package)],
                   check=True, capture_output=True)
    assert subprocess.run([sys.executable, '-I', str(ROOT / 'test/file_modes.py'), str(package)],
                          check=False, capture_output=True).returncode == status
