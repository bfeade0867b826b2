"""Decides how far a proof searches: whole if a file that it reads has changed, or with --long.

A proof is a file of tests that searches all states of code without I/O, or a great number of random
sequences. A whole search takes long. So the file chooses the bounds of its searches with
`is_whole(__file__)`:

    WHOLE = is_whole(__file__)
    LIVES = 60 if LONG else 20 if WHOLE else 3

The result of `is_whole` depends only on the contents of the file, of all files of the workspace
that it imports, directly or not, and of the `conftest.py` above it. When all tests of the file have
passed, `RECORD` keeps the hash of these contents. If the hash differs from the recorded hash, the
search is whole. A new clone has no recorded hash: in its first run the searches are not whole.
The root's conftest.py loads this module as a plugin of pytest.
"""
from __future__ import annotations

import ast
import hashlib
import json
import os
import sys
from collections import Counter, defaultdict
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, FrozenSet, Iterator, List, NamedTuple, Set

import pytest

ROOT = Path(__file__).resolve().parents[1]
RECORD = ROOT / 'build' / 'proofs.json'
LONG = os.environ.get('LD90_LONG_TESTS') == '1'
# False under a second Python: its tests only look for code that does not work under that version.
PROVES = os.environ.get('HYPOTHESIS_PROFILE') != 'compatibility'


class Proof(NamedTuple):
    """The data about a proof, in the report of each of its tests.

    file  -- path below the root
    tests -- number of tests in the file; 0: pytest was asked to run only some of them
    """

    file: str
    key: str
    is_whole: bool
    tests: int


def is_whole(file: str) -> bool:
    """Returns whether the proofs in this file of tests run whole now."""
    name, key = _name(file), key_of(Path(file))
    whole = PROVES and (LONG or recorded().get(name, key) != key)
    _asked[name] = Proof(name, key, whole, 0)
    return whole


def key_of(file: Path) -> str:
    """Returns the hash of all contents on which the result of the proofs in this file depends."""
    digest = hashlib.sha256(repr(sys.version_info[:2]).encode())
    for one in sorted(read_by(file)):
        content = hashlib.sha256(one.read_bytes()).hexdigest()
        digest.update(f'\n{_name(str(one))} {content}'.encode())
    return digest.hexdigest()


def read_by(file: Path) -> Set[Path]:
    """Returns this file, the files of the workspace that it imports, directly or not, and the
    `conftest.py` above it.
    """
    waiting = [file, *(folder / 'conftest.py' for folder in file.parents
                       if (folder / 'conftest.py').exists() and ROOT in (folder, *folder.parents))]
    found: Set[Path] = set()
    while waiting:
        one = waiting.pop()
        if one not in found:
            found.add(one)
            waiting.extend(path for name in names_imported(one) for around in _and_packages(name)
                           for path in _modules().get(around, ()))
    return found


@lru_cache(maxsize=None)
def names_imported(file: Path) -> FrozenSet[str]:
    """Returns all modules that a file imports, and imported names that may be modules."""
    names: Set[str] = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {str(node.module), *(f'{node.module}.{alias.name}' for alias in node.names)}
    return frozenset(names)


def recorded() -> Dict[str, str]:
    """Returns, for each proof, the key of the last run that passed."""
    try:
        return dict(json.loads(RECORD.read_text(encoding='utf-8')))
    except (OSError, ValueError):
        return {}


_asked: Dict[str, Proof] = {}
_proofs: Dict[str, Proof] = {}  # the proofs that ran
_passed: Dict[str, Dict[str, bool]] = defaultdict(dict)  # by file and test: whether it passed


@lru_cache(maxsize=None)
def _name(file: str) -> str:
    return Path(file).resolve().relative_to(ROOT).as_posix()


def _and_packages(name: str) -> Iterator[str]:
    words = name.split('.')
    return ('.'.join(words[:count]) for count in range(1, len(words) + 1))


@lru_cache(maxsize=None)
def _modules() -> Dict[str, List[Path]]:
    """Returns all Python files of the workspace, by the name under which they can be imported. Two
    files can have the same name.
    """
    found: Dict[str, List[Path]] = defaultdict(list)
    for file in (*ROOT.glob('src/*/src/**/*.py'), *ROOT.glob('src/*/test/**/*.py'),
                 *ROOT.glob('test/*.py')):
        words = [] if file.stem == '__init__' else [file.stem]
        folder = file.parent
        while (folder / '__init__.py').exists():
            words.insert(0, folder.name)
            folder = folder.parent
        found['.'.join(words)].append(file)
    return found


# -- hooks of pytest -------------------------------------------------------------------------------


@pytest.hookimpl(tryfirst=True)  # before any test is deselected
def pytest_collection_modifyitems(config: pytest.Config, items: List[pytest.Item]) -> None:
    """Adds to each test of a proof the data for the report. Puts proofs first: they take longest.
    """
    names = [_name(str(item.fspath)) for item in items]
    counts = Counter(names)
    is_selection = any('::' in word for word in config.args)
    for item, name in zip(items, names):
        if name in _asked:
            proof = _asked[name]._replace(tests=0 if is_selection else counts[name])
            item.user_properties.append(('proof', json.dumps(proof)))
    items.sort(key=lambda item: _name(str(item.fspath)) not in _asked)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Notes whether a test of a proof has passed."""
    for name, value in report.user_properties:
        if name == 'proof':
            proof = Proof(*json.loads(str(value)))
            _proofs[proof.file] = proof
            passed = _passed[proof.file]
            passed[report.nodeid] = report.passed and passed.get(report.nodeid, True)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Records each proof whose tests have all passed, and writes a note about the proofs that ran.
    """
    if hasattr(session.config, 'workerinput') or not _proofs or not PROVES:
        return
    passed = {file: proof.key for file, proof in _proofs.items()
              if len(_passed[file]) == proof.tests and all(_passed[file].values())}
    RECORD.parent.mkdir(exist_ok=True)
    RECORD.write_text(json.dumps({**recorded(), **passed}, indent=1, sort_keys=True),
                      encoding='utf-8')
    if session.config.option.xmlpath:
        Path(session.config.option.xmlpath).with_suffix('.proofs.note').write_text(_told() + '\n')


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Prints how many proofs ran whole."""
    if _proofs and PROVES:
        terminalreporter.write_line(_told())


def _told() -> str:
    whole = [proof.is_whole for proof in _proofs.values()]
    return (f'{sum(whole)} proofs ran whole; {whole.count(False)} ran within their default bounds: '
            'they have not changed since their last success here, or this was their first run here')
