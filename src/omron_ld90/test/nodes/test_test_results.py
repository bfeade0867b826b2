"""scripts/test.sh adds up results. If a test ran twice, its second result counts, and is named."""
from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Sequence

import pytest

SCRIPT = Path(__file__).resolve().parents[4] / 'scripts' / 'test_results.py'
FAILURE = '<failure message="too late"/>'


def results(*args: str) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, str(SCRIPT), *args], text=True, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


def junit(folder: Path, name: str, passed: Sequence[str], failed: Sequence[str]) -> str:
    cases = [f'<testcase classname="src.test_x" name="{case}"/>' for case in passed]
    cases += [f'<testcase classname="src.test_x" name="{case}">{FAILURE}</testcase>'
              for case in failed]
    file = folder / f'{name}.xml'
    file.write_text(f'<testsuites><testsuite tests="{len(cases)}" failures="{len(failed)}" '
                    f'errors="0">{"".join(cases)}</testsuite></testsuites>')
    return str(file)


@pytest.mark.parametrize('again_passed, again_failed, status, summary', [
    (['b', 'c'], [], 0, '3 passed, 0 failed, 0 skipped'),
    (['b'], ['c'], 1, '2 passed, 1 failed, 0 skipped')])
def test_what_ran_once_more_counts_with_its_second_result(tmp_path, again_passed, again_failed,
                                                          status, summary):
    first = junit(tmp_path, 'unit', passed=['a'], failed=['b', 'c'])
    assert results('failed', first).stdout == '2\n'
    again = junit(tmp_path, 'unit.again', again_passed, again_failed)
    assert results('once-more', first, again).returncode == 0
    told = results('summary', str(tmp_path))
    assert told.returncode == status
    assert told.stdout.splitlines()[-1] == summary
    assert 'src.test_x.b failed beside other tests, and ran once more, alone' in told.stdout


def test_a_failure_that_did_not_run_again_stays(tmp_path):
    first = junit(tmp_path, 'unit', passed=['a'], failed=['b', 'c'])
    again = junit(tmp_path, 'unit.again', passed=['b'], failed=[])
    results('once-more', first, again)
    assert results('failed', first).stdout == '1\n'
    assert results('summary', str(tmp_path)).returncode == 1


def test_uses_of_the_second_try_are_counted(tmp_path):
    junit(tmp_path, 'unit', passed=['a'], failed=[])
    assert '0 tests ran once more' in results('summary', str(tmp_path)).stdout.splitlines()
    (tmp_path / 'once_more.note').write_text('a ran once more\nb ran once more\n')
    assert '2 tests ran once more' in results('summary', str(tmp_path)).stdout.splitlines()


def test_the_ten_slowest_tests_of_each_kind_are_named(tmp_path):
    cases = ''.join(f'<testcase classname="src" name="t{i}" time="{i}"/>' for i in range(12))
    (tmp_path / 'unit.xml').write_text(f'<testsuites><testsuite>{cases}</testsuite></testsuites>')
    (tmp_path / 'system_tests.seconds').write_text('70 route\n125 rviz\n')
    told = [line.split() for line in results('summary', str(tmp_path)).stdout.splitlines()]
    assert [line[2] for line in told if line[1:2] == ['s']] == [
        *(f'src.t{i}' for i in range(11, 1, -1)), 'rviz', 'route']


def test_the_longest_test_starts_first_and_an_unknown_one_by_its_time_limit(tmp_path):
    seconds = tmp_path / 'seconds'
    seconds.write_text('5 route\n70 click\n')  # the test pose has a limit of 60 s
    assert results('longest-first', str(seconds), 'route', 'click', 'pose').stdout.split() == [
        'click', 'pose', 'route']
