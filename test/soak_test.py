#!/usr/bin/env python3
"""A small fleet keeps its promises during minutes of faults; the soak finds a planted defect."""
from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from system_support import run_cases

SOAK = Path(__file__).resolve().parents[1] / 'scripts/soak.sh'
FLEET = ('--ld90s', '2', '--agvs', '2')
MINUTE = 1.0 / 60.0


def soak(minutes: float, *options: str) -> subprocess.CompletedProcess:
    return subprocess.run([str(SOAK), f'{minutes * MINUTE:.4f}', *FLEET, *options], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=900,
                          check=False)


def test_every_promise_holds_for_five_minutes() -> None:
    ran = soak(5.0, '--seed', '1', '--verbose')
    assert ran.returncode == 0, ran.stdout
    assert 'every promise held' in ran.stdout


@pytest.mark.parametrize('defect, options, finding', [
    ('interlocking', ('--only', 'quiet', '--corrupted', '0.5'), 'are too near'),
    ('owed-stop', ('--only', 'stop-without-link', '--corrupted', '0'), 'after it was stopped'),
    ('restart', ('--only', 'stop-and-kill', '--corrupted', '0'), 'after it was stopped')])
def test_a_planted_defect_is_found(defect: str, options: tuple, finding: str) -> None:
    ran = soak(8.0, '--plant', defect, '--until-broken', *options)
    assert ran.returncode == 1, ran.stdout
    assert finding in ran.stdout


if __name__ == '__main__':
    run_cases(__file__)
