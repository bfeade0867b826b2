"""The example that drives without ROS, run as its first lines describe."""
from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

from omron_ld90_sim import Simulator

ROOT = Path(__file__).parents[3]
EXAMPLE = ROOT / 'examples/drive_without_ros.py'
PATHS = re.search(r'PYTHONPATH=(\S+)', EXAMPLE.read_text()).group(1)


def run(*arguments: str, password: str = 'adept') -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, str(EXAMPLE), *arguments], input=password + '\n', cwd=ROOT, text=True,
        env={**os.environ, 'PYTHONPATH': PATHS}, capture_output=True, timeout=60, check=False)


def test_it_lists_goals_and_drives_to_one():
    with Simulator(ROOT / 'maps/lab.map', speed=10.0) as robot:
        listed = run('127.0.0.1', '--port', str(robot.port))
        assert '8' in listed.stdout.split(), listed
        driven = run('127.0.0.1', '8', '--port', str(robot.port))
        assert driven.stdout.endswith('succeeded: Arrived at 8\n'), driven
        assert driven.returncode == 0
        refused = run('127.0.0.1', 'nowhere', '--port', str(robot.port))
        assert 'no such goal' in refused.stdout
        assert refused.returncode == 1


def test_it_says_why_it_cannot_connect():
    with Simulator(ROOT / 'maps/lab.map') as robot:
        refused = run('127.0.0.1', '--port', str(robot.port), password='wrong')
    assert 'refused the password' in refused.stderr
    assert 'wrong' not in refused.stderr.replace('wrong password', '')
    assert refused.returncode == 1
