"""A proof runs whole with --long, or if a file that it reads has changed since its last success.

Under a second Python version, tests run again if something that they read has changed.
"""
from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Dict

import pytest

ROOT = Path(__file__).resolve().parents[3]
FILES = {
    'pytest.ini': '[pytest]\npythonpath = test\n',
    # no libraries, so that each run starts fast
    'conftest.py': "pytest_plugins = ['proofs', 'second_python']\n",
    'src/one/src/one/__init__.py': '',
    'src/one/src/one/inner.py': 'from two.limits import MOST\n',
    'src/two/src/two/__init__.py': '',
    'src/two/src/two/limits.py': 'MOST = 3\n',
    'src/two/src/two/other.py': 'LEAST = 1\n',
    'src/one/test/counting.py': 'import one.inner\n',
    'src/one/test/test_proof.py': '''
import os
from counting import one
from proofs import is_whole
WHOLE = is_whole(__file__)
def test_a():
    print('whole' if WHOLE else 'default')
def test_b():
    assert one.inner.MOST < 10
'''}


class Workspace:
    """A small workspace with one proof."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def fill(self) -> None:
        """Writes the files of the workspace."""
        for name, text in FILES.items():
            self.write(name, text)
        for name in ('test/proofs.py', 'test/second_python.py'):
            self.write(name, (ROOT / name).read_text())

    def write(self, name: str, text: str) -> None:
        (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
        (self.folder / name).write_text(text)

    def extent(self, *options: str, **environment: str) -> str:
        """Runs the tests. Returns how the proof ran: `whole` or `default`."""
        told = self.run(*options, **environment)
        is_whole = '1 proofs ran whole' in told
        assert '-n' in options or is_whole == ('whole\n' in told), told  # workers print nothing
        return 'whole' if is_whole else 'default'

    def runs_under_the_second_python(self, *options: str, **environment: str) -> bool:
        """Runs the tests under the second Python. Returns False if they were left out."""
        told = self.run(*options, HYPOTHESIS_PROFILE='compatibility', **environment)
        is_left_out = '1 files of tests were not repeated' in told
        assert is_left_out == ('default\n' not in told), told
        return not is_left_out

    def run(self, *options: str, **environment: str) -> str:
        """Runs the tests of the workspace. Returns the printed text."""
        known = {name: value for name, value in os.environ.items()
                 if name not in ('LD90_LONG_TESTS', 'HYPOTHESIS_PROFILE', 'PYTEST_XDIST_WORKER')}
        path = os.pathsep.join(str(self.folder / 'src' / name / 'src') for name in ('one', 'two'))
        return subprocess.run(
            [sys.executable, '-m', 'pytest', '-s', '-q', '-p', 'no:cacheprovider',
             *(('-p', 'xdist') if '-n' in options else ()), *(options or ('src',))],
            cwd=str(self.folder), check=False, text=True, stdout=subprocess.PIPE,
            env={**known, 'PYTHONPATH': path, 'PYTEST_DISABLE_PLUGIN_AUTOLOAD': '1',
                 'PYTHONDONTWRITEBYTECODE': '1', **environment}).stdout


@pytest.fixture(scope='module')
def passed(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """Returns a workspace whose proof has passed once. Tests change copies of it."""
    workspace = Workspace(tmp_path_factory.mktemp('passed'))
    workspace.fill()
    assert workspace.extent() == 'default'
    return workspace


@pytest.fixture
def tested(passed: Workspace, tmp_path: Path) -> Workspace:
    """Returns a copy of `passed` for one test."""
    return Workspace(Path(shutil.copytree(str(passed.folder), str(tmp_path / 'workspace'))))


def test_a_proof_runs_whole_once_after_a_change_of_a_file_that_it_reads(tested):
    assert tested.extent() == 'default'
    tested.write('src/two/src/two/limits.py', 'MOST = 4\n')  # read through two other files
    assert tested.extent() == 'whole'
    assert tested.extent() == 'default'


def test_a_proof_does_not_run_whole_after_a_change_of_another_file(tested):
    tested.write('src/two/src/two/other.py', 'LEAST = 2\n')
    assert tested.extent() == 'default'


@pytest.mark.parametrize('selection', [
    ('src/one/test/test_proof.py::test_a',), ('src', '-k', 'test_a'),
    ('src', '-n', '2', '-k', 'test_a')])
def test_a_proof_that_ran_in_part_is_not_recorded(tested, selection):
    tested.write('src/two/src/two/limits.py', 'MOST = 4\n')
    assert tested.extent(*selection) == 'whole'
    assert tested.extent() == 'whole'


def test_a_proof_that_failed_runs_whole_until_it_passes(tested):
    for most in (11, 11, 5):
        tested.write('src/two/src/two/limits.py', f'MOST = {most}\n')
        assert tested.extent() == 'whole'
    assert tested.extent() == 'default'


def test_with_long_a_proof_runs_whole(tested):
    assert tested.extent(LD90_LONG_TESTS='1') == 'whole'


def test_several_processes_record_together(tested):
    tested.write('src/two/src/two/limits.py', 'MOST = 4\n')
    tested.extent('src', '-n', '2')
    assert tested.extent() == 'default'


def test_a_second_python_version_proves_nothing(tested):
    tested.write('src/two/src/two/limits.py', 'MOST = 4\n')
    assert tested.extent(HYPOTHESIS_PROFILE='compatibility') == 'default'
    assert tested.extent() == 'whole'


@pytest.fixture(scope='module')
def passed_there(passed: Workspace, tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """Returns a workspace whose tests have passed under the second Python."""
    folder = tmp_path_factory.mktemp('there') / 'workspace'
    workspace = Workspace(Path(shutil.copytree(str(passed.folder), str(folder))))
    assert workspace.runs_under_the_second_python()
    return workspace


@pytest.fixture
def tested_there(passed_there: Workspace, tmp_path: Path) -> Workspace:
    """Returns a copy of `passed_there` for one test."""
    return Workspace(Path(shutil.copytree(str(passed_there.folder), str(tmp_path / 'workspace'))))


def test_under_a_second_python_tests_are_repeated_after_a_change_of_what_they_read(tested_there):
    assert not tested_there.runs_under_the_second_python()
    tested_there.write('src/two/src/two/limits.py', 'MOST = 4\n')
    assert tested_there.runs_under_the_second_python('src', '-k', 'test_a')  # is not recorded
    assert tested_there.runs_under_the_second_python()
    assert not tested_there.runs_under_the_second_python()
    tested_there.write('src/two/sites/yard.yaml', 'a file that a test may read')
    assert tested_there.runs_under_the_second_python()


def test_under_a_second_python_tests_are_repeated_until_they_pass(tested_there):
    tested_there.write('src/two/src/two/limits.py', 'MOST = 11\n')
    assert all(tested_there.runs_under_the_second_python() for _ in range(2))
    tested_there.write('src/two/src/two/limits.py', 'MOST = 3\n')
    assert not tested_there.runs_under_the_second_python()


def test_under_a_second_python_what_looks_at_the_whole_workspace_always_runs(tested_there):
    tested_there.write('pytest.ini', FILES['pytest.ini'] + 'markers = every_python\n')
    proof = FILES['src/one/test/test_proof.py'].replace(
        'def test_b', 'import pytest\n@pytest.mark.every_python\ndef test_b')
    tested_there.write('src/one/test/test_proof.py', proof)
    assert all(tested_there.runs_under_the_second_python() for _ in range(2))


@pytest.mark.parametrize('name', ['fleet_simulation/test/test_guards.py',
                                  'fleet_core/test/interlocking/test_yard.py'])
def test_all_that_is_loaded_with_a_proof_is_read_by_it(name, tmp_path):
    """A process imports a proof. `read_by` names each workspace file that the process has loaded.
    """
    (tmp_path / 'loaded.py').write_text('''
import sys
from pathlib import Path
def pytest_collection_finish(session):
    import proofs
    read = proofs.read_by(Path(str(session.items[0].fspath)))
    for module in list(sys.modules.values()):
        file = Path(getattr(module, '__file__', None) or '/')
        # build may have virtual environments; second_python leaves tests out under another Python
        if (proofs.ROOT in file.parents and proofs.ROOT / 'build' not in file.parents
                and file.suffix == '.py' and file not in read and file.stem != 'second_python'):
            print('not read:', file)
''')
    environment: Dict[str, str] = {**os.environ, 'PYTHONPATH': os.pathsep.join(
        [str(tmp_path), *map(str, ROOT.glob('src/*/src')), os.environ.get('PYTHONPATH', '')])}
    told = subprocess.run(
        [sys.executable, '-m', 'pytest', '-s', '-q', '--collect-only', '-p', 'no:cacheprovider',
         '-p', 'loaded', str(ROOT / 'src' / name)], cwd=str(ROOT), check=True, text=True,
        stdout=subprocess.PIPE, env=environment).stdout
    assert name in told
    assert [line for line in told.splitlines() if line.startswith('not read:')] == []
