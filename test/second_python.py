"""Under a second Python version tests run again when something that they read has changed.

These tests only look for code that does not work there at all, always with the same examples. So
their result depends on contents alone, as that of a proof does (see `proofs`): on the files that
their file imports, directly or not, and on all files of the workspace that are not Python. When all
tests of a file have passed, `RECORD` keeps the hash of these contents. While it is the same, the
file is left out. Files with tests that look at the whole workspace (marked `every_python`) always
run; with --long everything runs. The root's conftest.py loads this module as a plugin of pytest.
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

_passed: Dict[str, bool] = {}  # by file, whether all of its tests have passed
_left_out: Set[str] = set()


def recorded() -> Dict[str, str]:
    """By file, the key with which all of its tests passed last."""
    try:
        return dict(json.loads(RECORD.read_text(encoding='utf-8')))
    except (OSError, ValueError):
        return {}


def key(file: str) -> str:
    """The hash of all contents on which the results of the tests in a file depend."""
    return f'{key_of(ROOT / file)} {_other_files()}'


@lru_cache(maxsize=None)
def _other_files() -> str:
    """The hash of the files in which tests may read besides Python's."""
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
    """Are only some tests of a file asked for?"""
    return any('::' in word for word in config.args) or bool(
        config.option.keyword or getattr(config.option, 'lf', False))


@pytest.hookimpl(trylast=True)  # after those were deselected that do not run there at all
def pytest_collection_modifyitems(config: pytest.Config, items: List[pytest.Item]) -> None:
    """Leaves out the files of which nothing that they read has changed since they passed."""
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
    """Records the files of which all tests have passed."""
    if PROVES or _is_selection(session.config):
        return
    passed = {name: key(name) for name, is_passed in _passed.items() if is_passed}
    RECORD.parent.mkdir(exist_ok=True)
    RECORD.write_text(json.dumps({**recorded(), **passed}, indent=1, sort_keys=True),
                      encoding='utf-8')


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Tells how many files were left out."""
    if _left_out:
        terminalreporter.write_line(
            f'{len(_left_out)} files of tests were not repeated, because nothing that they read '
            'has changed since they passed under this Python')
