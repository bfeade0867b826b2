"""No script imports from the working directory: the owner of that folder could run code."""
from __future__ import annotations

import re
from pathlib import Path
from typing import Iterator, List, Tuple

import pytest

ROOT = Path(__file__).resolve().parents[3]
#: `-m`, `-c` and `-` put the working directory in front of all modules; `-I` does not.
_PYTHON = re.compile(r'python(?:3(?:\.\d+)?)?["\']?\s+(?:-m|-c|-)(?=\s)')
_PYTEST = 'python -m pytest', 'python3 -m pytest'  # runs in the root of the workspace
#: A list of folders with an empty entry, which stands for the working directory.
_EMPTY = re.compile(r'PYTHONPATH="?(?:\$\(printf \'%s:\'|'
                    r'[^"\s]*(?::|\$\{PYTHONPATH:-\}|:\$PYTHONPATH)"(?=\s|$))')


def commands() -> Iterator[Tuple[Path, str]]:
    """Yields the commands of all scripts, images and workflows, with their files."""
    for file in (*ROOT.glob('scripts/**/*.sh'), ROOT / 'Dockerfile',
                 *ROOT.glob('.github/workflows/*')):
        for line in file.read_text(encoding='utf-8').replace('\\\n', ' ').splitlines():
            if not line.lstrip().startswith('#'):
                yield file, line


def wrong(line: str) -> bool:
    """Returns whether a command imports from the working directory."""
    for allowed in _PYTEST:
        line = line.replace(allowed, '')
    return bool(_PYTHON.search(line) or _EMPTY.search(line))


def test_no_script_imports_from_the_working_directory():
    found: List[str] = [f'{file.relative_to(ROOT)}: {line.strip()}'
                        for file, line in commands() if wrong(line)]
    assert found == []


def test_pytest_runs_in_the_root_of_the_workspace():
    for file, line in commands():
        if any(allowed in line for allowed in _PYTEST):
            assert '\ncd "$root"\n' in file.read_text(encoding='utf-8'), file


@pytest.mark.parametrize('line', [
    'python3 -m venv x', '/usr/bin/python3 - "$1" <<END', '"$here/bin/python" -c "import a"',
    'PYTHONPATH="$(printf \'%s:\' src/*/src)" ./run', 'export PYTHONPATH="$root/test:$PYTHONPATH"',
    'PYTHONPATH="$root/test:${PYTHONPATH:-}"'])
def test_an_import_from_the_working_directory_is_found(line):
    assert wrong(line)
