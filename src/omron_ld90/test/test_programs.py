"""Ctrl-C ends every program of the workspace without a traceback, even in its first line."""
from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[2]


def test_every_node_begins_so():
    """Applies to all programs of modules that handle ROS's signals themselves."""
    nodes = [text for text in (file.read_text() for file in SOURCES.glob('*/nodes/*'))
             if re.search(r'[\'"]\w+\.nodes\.\w+[\'"]|from \w+\.nodes\.\w+ import main', text)]
    assert len(nodes) >= 15
    assert [text for text in nodes if 'from node_program import run_' not in text] == []


def test_every_command_begins_so():
    """Applies to all programs except those of packages that pip installs without `node_program`."""
    others = {str(file.relative_to(SOURCES)) for file in SOURCES.glob('*/nodes/*')
              if 'from node_program import run_' not in file.read_text()}
    assert others == {'omron_ld90_sim/nodes/ld90_sim', 'omron_map/nodes/ld_map',
                      'trajectory_graph/nodes/split_edges'}


@pytest.mark.parametrize('begin, wait', [
    ('omron_map.cli', "omron_map.cli._parser = lambda: Waits()"),
    ('trajectory_graph.cli', "trajectory_graph.cli.load_graph = wait")])
def test_commands_of_other_packages_end_so_too(begin, wait):
    paths = [str(SOURCES / package / 'src') for package in ('omron_map', 'trajectory_graph')]
    function = 'main' if begin == 'omron_map.cli' else 'split_edges_main'
    ended = subprocess.run(
        [sys.executable, '-c', f"""
import os, signal, sys
sys.path[:0] = {paths!r}
import {begin}
signal.signal(signal.SIGINT, signal.default_int_handler)    # what runs in the background ignores it
def wait(*_):
    os.kill(os.getpid(), signal.SIGINT)
    signal.pause()
class Waits:
    run = staticmethod(wait)
    def parse_args(self, _):
        return self
{wait}
sys.exit({begin}.{function}(['--longest', '1', 'a', 'b']))
"""], capture_output=True, text=True, timeout=60.0)
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, '', '')
