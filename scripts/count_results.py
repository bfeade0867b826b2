"""Adds up what test.sh left in its results folder; prints skips, failures and the one last line.

Read are `checks.tsv` (verdict, name, reason), pytest's JUnit files, and rostest's result files,
which count a skipped test as passed: `*.skips`, written by the tests, says which those are.
"""
from __future__ import annotations

import sys
import xml.etree.ElementTree as ElementTree
from collections import Counter
from pathlib import Path
from typing import Iterator, Tuple

Result = Tuple[str, str, str]  # verdict, name, reason


def checks(folder: Path) -> Iterator[Result]:
    """Verdicts that test.sh wrote itself."""
    for line in _lines(folder / 'checks.tsv'):
        verdict, name, reason = line.split('\t')
        yield verdict, name, reason


def junit(folder: Path) -> Iterator[Result]:
    """Verdicts of the unit tests."""
    for file in sorted(folder.glob('*.xml')):
        for case in ElementTree.parse(file).getroot().iter('testcase'):
            name = f'{case.get("classname")}.{case.get("name")}'
            skipped = case.find('skipped')
            if skipped is not None:
                yield 'skipped', name, skipped.get('message', '')
            elif case.find('failure') is not None or case.find('error') is not None:
                yield 'failed', name, 'see above'
            else:
                yield 'passed', name, ''


def rostests(folder: Path) -> Iterator[Result]:
    """Verdicts of the system tests; a failed file is counted by test.sh in `checks.tsv`."""
    skips = dict(line.split(': ', 1) for file in folder.glob('*.skips') for line in _lines(file))
    for name, reason in skips.items():
        yield 'skipped', name, reason
    skipped_names = {name.rsplit('.', 1)[-1] for name in skips}
    for file in sorted(folder.glob('ros/**/rosunit-*.xml')):
        for case in ElementTree.parse(file).getroot().iter('testcase'):
            failed = case.find('failure') is not None or case.find('error') is not None
            if not failed and case.get('name') not in skipped_names:
                yield 'passed', f'{case.get("classname")}.{case.get("name")}', ''


def _lines(file: Path) -> Iterator[str]:
    if file.exists():
        yield from file.read_text(encoding='utf-8').splitlines()


def main() -> int:
    """Print the summary; 0 when something was tested and nothing failed."""
    folder = Path(sys.argv[1])
    results = [*checks(folder), *junit(folder), *rostests(folder)]
    counts = Counter(verdict for verdict, _, _ in results)
    print()
    for wanted in ('skipped', 'failed'):
        for verdict, name, reason in results:
            if verdict == wanted:
                print(f'{verdict}: {name}: {reason}')
    print(f'{counts["passed"]} passed, {counts["failed"]} failed, {counts["skipped"]} skipped')
    return 0 if counts['passed'] and not counts['failed'] else 1


if __name__ == '__main__':
    sys.exit(main())
