"""Writes test results as JUnit files in catkin's folder, and counts them.

    test_results.py record FOLDER passed|failed|skipped NAME [REASON]
    test_results.py failed FILE             how many tests of a JUnit file failed
    test_results.py once-more FILE AGAIN    tests that ran again count with their second result
    test_results.py longest-first FILE NAME...    system tests in the order in which they start
    test_results.py summary FOLDER

`catkin_test_results` reads the same files. It does not replace `summary`: it does not say which
tests were skipped and why, and it counts each rostest file twice.
"""
from __future__ import annotations

import re
import sys
import xml.etree.ElementTree as ElementTree
from collections import Counter
from pathlib import Path
from typing import Dict, Iterator, List, Sequence, Tuple

TESTS = Path(__file__).resolve().parents[1] / 'test'
SLOWEST = 10  # number of printed tests of each kind
Result = Tuple[str, str, str]  # verdict, name, reason
ELEMENTS = {'failed': 'failure', 'skipped': 'skipped'}


def record(folder: Path, verdict: str, name: str, reason: str = '') -> None:
    """Writes the result of a check, such as lint, that is not a test of pytest or rostest."""
    suite = ElementTree.Element('testsuite', name=name, tests='1', errors='0',
                                failures=str(int(verdict == 'failed')),
                                skipped=str(int(verdict == 'skipped')))
    case = ElementTree.SubElement(suite, 'testcase', classname='checks', name=name, time='0')
    if verdict in ELEMENTS:
        ElementTree.SubElement(case, ELEMENTS[verdict], message=reason)
    ElementTree.ElementTree(suite).write(folder / f'check-{name}.xml', encoding='utf-8')


def failures(suite: ElementTree.Element) -> List[ElementTree.Element]:
    """Returns the failed tests below an element of a JUnit file."""
    return [case for case in suite.iter('testcase')
            if case.find('failure') is not None or case.find('error') is not None]


def once_more(first: Path, again: Path) -> None:
    """Removes, from the first file, failures of tests that ran again; writes a note about each.
    """
    tree = ElementTree.parse(first)
    repeated = sorted(map(_name, ElementTree.parse(again).getroot().iter('testcase')))
    for suite in tree.getroot().iter('testsuite'):
        for case in failures(suite):
            if _name(case) in repeated:
                suite.remove(case)
        for attribute, found in (('tests', '.'), ('failures', 'failure'), ('errors', 'error')):
            suite.set(attribute, str(len(suite.findall(f'testcase/{found}'))))
    tree.write(first, encoding='utf-8')
    with (first.parent / 'once_more.note').open('a') as note:
        note.writelines(f'{name} failed beside other tests, and ran once more, alone\n'
                        for name in repeated)


def _name(case: ElementTree.Element) -> str:
    return f'{case.get("classname")}.{case.get("name")}'


def seconds_of(file: Path) -> Dict[str, float]:
    """Returns the duration (s) of each system test, from lines with seconds and a name. The last
    line of a test counts.
    """
    if not file.exists():
        return {}
    lines = (line.split() for line in file.read_text().splitlines())
    return {name: float(seconds) for seconds, name in lines}


def longest_first(known: Dict[str, float], names: Sequence[str]) -> List[str]:
    """Returns the names by duration, the longest first. In place of an unknown duration, the time
    limit in `test/NAME.test` counts.
    """
    def expected(name: str) -> float:
        limits = re.findall(r'time-limit="(\d+)"', (TESTS / f'{name}.test').read_text())
        return known.get(name, max(map(float, limits), default=0.0))
    return sorted(names, key=expected, reverse=True)


def slowest(folder: Path) -> Iterator[str]:
    """Yields lines about the tests that took longest."""
    unit = folder / 'unit.xml'
    cases = ElementTree.parse(unit).getroot().iter('testcase') if unit.exists() else ()
    kinds = {'unit': [(float(case.get('time', '0')), _name(case)) for case in cases],
             'system': [(seconds, name) for name, seconds
                        in seconds_of(folder / 'system_tests.seconds').items()]}
    for kind, took in kinds.items():
        if took:
            yield f'the slowest {kind} tests:'
            yield from (f'  {seconds:6.1f} s  {name}'
                        for seconds, name in sorted(took, reverse=True)[:SLOWEST])


def results(folder: Path) -> Iterator[Result]:
    """Yields each test of each JUnit file below `folder`."""
    for file in sorted(folder.rglob('*.xml')):
        for case in ElementTree.parse(file).getroot().iter('testcase'):
            name = _name(case)
            skipped, failure = case.find('skipped'), case.find('failure')
            if skipped is not None:
                yield 'skipped', name, skipped.get('message', '')
            elif failure is not None:
                yield 'failed', name, failure.get('message') or 'see above'
            elif case.find('error') is not None:
                yield 'failed', name, 'see above'
            elif not file.name.startswith('rostest-'):  # these files only say that a test has run
                yield 'passed', name, ''


def summary(folder: Path) -> int:
    """Prints skips, failures, the slowest tests, the contents of `*.note` files, and the last line.

    Returns 0 if nothing failed and something passed.
    """
    found = list(results(folder))
    counts = Counter(verdict for verdict, _, _ in found)
    print()
    for wanted in ('skipped', 'failed'):
        for verdict, name, reason in found:
            if verdict == wanted:
                print(f'{verdict}: {name}: {reason.splitlines()[0] if reason else ""}')
    print('\n'.join(slowest(folder)))
    for note in sorted(folder.glob('*.note')):
        print(note.read_text().rstrip())
    repeated = folder / 'once_more.note'
    times = len(repeated.read_text().splitlines()) if repeated.exists() else 0
    print(f'{times} tests ran once more')
    print(f'{counts["passed"]} passed, {counts["failed"]} failed, {counts["skipped"]} skipped')
    return 0 if counts['passed'] and not counts['failed'] else 1


if __name__ == '__main__':
    command, folder_name, *rest = sys.argv[1:]
    if command == 'record':
        record(Path(folder_name), *rest)
    elif command == 'failed':
        print(len(failures(ElementTree.parse(folder_name).getroot())))
    elif command == 'once-more':
        once_more(Path(folder_name), Path(rest[0]))
    elif command == 'longest-first':
        print('\n'.join(longest_first(seconds_of(Path(folder_name)), rest)))
    else:
        sys.exit(summary(Path(folder_name)))
