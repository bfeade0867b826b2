"""Launch files give all Python nodes, and only these, to the node host, which has their modules."""
from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from roslaunch.config import load_config_default
from roslaunch.core import RLException

from fleet_bringup.launch_file import MODULES

ROOT = Path(__file__).resolve().parents[4]
FILES = [ROOT / 'launch' / f'{name}.launch' for name in ('robot', 'visualisation', 'vda5050')] + [
    ROOT / 'src/graph_fleet_manager/launch/fleet_manager.launch']
IN_NO_HOST = {'embedded_broker'}  # this process becomes mosquitto


def nodes_of(file):
    return [node for node in ET.parse(file).iter('node')
            if (ROOT / 'src' / node.get('pkg') / 'nodes' / node.get('type')).exists()
            and node.get('type') not in IN_NO_HOST]


def module_of(node):
    program = ROOT / 'src' / node.get('pkg') / 'nodes' / node.get('type')
    return re.search(r"run_main\('([\w.]+)'\)", program.read_text()).group(1)


@pytest.mark.parametrize('file', FILES, ids=lambda file: file.stem)
def test_with_hosted_every_python_node_is_a_fork_of_the_host(file):
    assert len(nodes_of(file)) >= 1
    assert {node.get('launch-prefix') for node in nodes_of(file)} == {
        "$(eval '\"' + arg('hosted_by') + '\"' if arg('hosted') else '')"}


def test_programs_that_are_not_python_are_no_forks():
    others = [node for file in FILES for node in ET.parse(file).iter('node')
              if node not in nodes_of(file) and node.get('pkg') == 'robot_state_publisher']
    assert [node.get('launch-prefix') for node in others] == [None] * len(others)


def test_the_host_imports_what_its_nodes_run():
    imported = {word for name in ('robot_host', 'full_stack')
                for word in re.findall(r'\w+\.nodes\.\w+',
                                       (ROOT / 'launch' / f'{name}.launch').read_text())}
    run = {module_of(node) for file in FILES for node in nodes_of(file)}
    assert run <= imported
    assert {one for one in run if one.startswith('graph_fleet_manager')} <= set(MODULES)


def test_a_node_listed_twice_is_refused_before_anything_starts(tmp_path):
    robot = ("""<include file="$(find omron_ld90)/launch/robot.launch">
        <arg name="hosted" value="true"/> <arg name="node_host" value="false"/></include>""")
    file = tmp_path / 'twice.launch'
    file.write_text(f'<launch>{robot}{robot}</launch>')
    with pytest.raises(RLException, match='multiple nodes named'):
        load_config_default([str(file)], None, verbose=False)
