"""The nodes that roslaunch would start for launch files with hosted nodes."""
from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

NODE = '''<node name="{name}" pkg="rostopic" type="rostopic" args="list"
                launch-prefix="$(find node_host)/hosted"/>'''


def nodes_of(folder: Path, *names: str) -> subprocess.CompletedProcess:
    """Returns the result of `roslaunch --nodes`, which needs no ROS master and starts nothing."""
    launch = folder / 'some.launch'
    launch.write_text('\n'.join([
        '<launch>', '<include file="$(find node_host)/launch/node_host.launch"/>',
        *(NODE.format(name=name) for name in names), '</launch>']))
    return subprocess.run(['roslaunch', '--nodes', str(launch)], text=True, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60)


@pytest.mark.parametrize('names', [('one', 'one'), ('node_host',)])
def test_a_node_listed_twice_is_refused_before_anything_starts(tmp_path, names):
    ran = nodes_of(tmp_path, *names)
    assert ran.returncode != 0
    assert f'multiple nodes named [/{names[0]}]' in ran.stdout


def test_nodes_of_different_names_are_not(tmp_path):
    ran = nodes_of(tmp_path, 'one', 'other')
    assert ran.returncode == 0, ran.stdout
    assert {'/one', '/other', '/node_host'} <= set(ran.stdout.split())
