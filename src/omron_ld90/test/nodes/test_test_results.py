"""How scripts/test.sh adds up results: a second try counts, is named, and hides no failure."""
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
