"""Under a second Python version, tests run again only if something that they read has changed.

These tests only look for code that does not work under that version, always with the same examples.
So their result depends only on contents, like the result of a proof (see `proofs`): on the contents
of the test file, of the files that it imports, directly or not, and of all files of the workspace
that are not Python. When all tests of a file have passed, `RECORD` keeps the hash of these
contents. While the hash is the same, the file is left out. A file with tests of the whole workspace
(marked `every_python`) always runs.
With --long every file runs. The root's conftest.py loads this module as a plugin of pytest.
"""
from __future__ import annotations

import hashlib
import json
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, List, Set

import pytest
from proofs import LONG, PROVES, ROOT, key_of

RECORD = ROOT / 'build' / 'second_python.json'
FOLDERS = ('src', 'maps', 'scripts/pins')

_passed: Dict[str, bool] = {}  # by file: whether all of its tests have passed
_left_out: Set[str] = set()


def recorded() -> Dict[str, str]:
    """Returns, for each file, the key of the last run in which all of its tests passed."""
    try:
        return dict(json.loads(RECORD.read_text(encoding='utf-8')))
    except (OSError, ValueError):
        return {}


def key(file: str) -> str:
    """Returns the hash of all contents on which the results of the tests in a file depend."""
    return f'{key_of(ROOT / file)} {_other_files()}'


@lru_cache(maxsize=None)
def _other_files() -> str:
    """Returns the hash of all files that tests may read, except Python files."""
    digest = hashlib.sha256()
    for folder in FOLDERS:
        for file in sorted((ROOT / folder).rglob('*')):
            name = file.relative_to(ROOT).as_posix()
            if file.suffix not in ('.py', '.pyc') and '/.' not in name and file.is_file():
                content = hashlib.sha256(file.read_bytes()).hexdigest()
                digest.update(f'\n{name} {content}'.encode())
    return digest.hexdigest()


def _name(item: pytest.Item) -> str:
    return Path(str(item.fspath)).resolve().relative_to(ROOT).as_posix()


def _is_selection(config: pytest.Config) -> bool:
    """Returns whether pytest was asked for only some tests of a file."""
    return any('::' in word for word in config.args) or bool(
        config.option.keyword or getattr(config.option, 'lf', False))


@pytest.hookimpl(trylast=True)  # after the deselection of tests that never run there
def pytest_collection_modifyitems(config: pytest.Config, items: List[pytest.Item]) -> None:
    """Leaves out each file of tests that passed with the present contents of all that it reads."""
    if PROVES or LONG or _is_selection(config):
        return
    always = {_name(item) for item in items if item.get_closest_marker('every_python')}
    known = recorded()
    _left_out.update(name for name in {*map(_name, items)} - always
                     if name in known and known[name] == key(name))
    config.hook.pytest_deselected(items=[item for item in items if _name(item) in _left_out])
    items[:] = [item for item in items if _name(item) not in _left_out]


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Notes whether a test has passed."""
    name = report.nodeid.partition('::')[0]
    _passed[name] = not report.failed and _passed.get(name, True)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Records the files whose tests have all passed."""
    if PROVES or _is_selection(session.config):
        return
    passed = {name: key(name) for name, is_passed in _passed.items() if is_passed}
    RECORD.parent.mkdir(exist_ok=True)
    RECORD.write_text(json.dumps({**recorded(), **passed}, indent=1, sort_keys=True),
                      encoding='utf-8')


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Prints how many files were left out."""
    if _left_out:
        terminalreporter.write_line(
            f'{len(_left_out)} files of tests were not repeated, because nothing that they read '
            'has changed since they passed under this Python')
