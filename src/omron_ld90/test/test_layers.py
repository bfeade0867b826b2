"""Upper layers import only lower ones, as docs/explanation/architecture.md says."""
from __future__ import annotations

import ast
from pathlib import Path
from typing import Iterator, Set

import pytest

SOURCES = Path(__file__).resolve().parents[2]
OURS = ('omron_arcl', 'omron_map', 'route_protocol', 'trajectory_graph', 'omron_ld90',
        'omron_ld90_sim')
ROS = {'rospy', 'actionlib', 'tf2_ros', 'rosgraph', 'diagnostic_updater', 'genpy', 'roslib'}
SOCKETS = {'socket', 'socketserver', 'selectors', 'asyncio'}

# layer -> the packages and layers of ours that it may import besides itself
ALLOWED = {
    'omron_arcl': set(),
    'omron_map': set(),
    'route_protocol': set(),
    'trajectory_graph': set(),
    'omron_ld90.bridge': {'omron_arcl', 'omron_map', 'route_protocol', 'trajectory_graph',
                          'omron_ld90'},
    'omron_ld90.converter': {'omron_arcl', 'omron_map', 'trajectory_graph', 'omron_ld90'},
    'omron_ld90.operator': {'omron_arcl', 'omron_map', 'route_protocol', 'trajectory_graph',
                            'omron_ld90'},
    'omron_ld90_sim.motion': {'omron_map'},
    'omron_ld90_sim.devices': {'omron_map', 'omron_ld90_sim', 'omron_ld90_sim.motion'},
    'omron_ld90_sim.behaviour': {'omron_map', 'omron_ld90_sim', 'omron_ld90_sim.motion',
                                 'omron_ld90_sim.devices'},
    'omron_ld90_sim.interface': {'omron_map', 'omron_ld90_sim', 'omron_ld90_sim.motion',
                                 'omron_ld90_sim.devices', 'omron_ld90_sim.behaviour'},
}
WITH_LAYERS = ('omron_ld90', 'omron_ld90_sim')
TRANSPORTS = {'connection.py', 'transport.py', 'client.py', 'listener.py'}  # modules of omron_arcl


def files_of(layer: str) -> Iterator[Path]:
    package = layer.split('.')[0]
    return (SOURCES / package / 'src' / Path(*layer.split('.'))).rglob('*.py')


def imported_by(file: Path) -> Set[str]:
    """Names of the modules that a file imports, on any line."""
    names: Set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            names.update(name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.update(f'{node.module}.{name.name}' for name in node.names)
    return names


def layer_of(module: str) -> str:
    """`omron_ld90.bridge` for `omron_ld90.bridge.motions.Motion`, `omron_map` for its modules."""
    package, _, rest = module.partition('.')
    layer = f'{package}.{rest.split(".")[0]}'
    has_layers = package in WITH_LAYERS and (
        layer in ALLOWED or layer == 'omron_ld90.nodes')
    return layer if has_layers else package


@pytest.mark.parametrize('layer', ALLOWED)
def test_a_layer_imports_no_upper_one_and_no_ros(layer: str):
    found = {}
    for file in files_of(layer):
        wrong = {module for module in imported_by(file)
                 if module.split('.')[0] in ROS or module.split('.')[0].endswith('_msgs')
                 or module.split('.')[0] in OURS
                 and layer_of(module) not in {layer, *ALLOWED[layer]}}
        if wrong:
            found[file.name] = sorted(wrong)
    assert found == {}


@pytest.mark.parametrize('layer', [layer for layer in ALLOWED if layer not in (
    'omron_arcl', 'omron_ld90_sim.interface')])
def test_sockets_are_in_the_transports_only(layer: str):
    assert [file.name for file in files_of(layer) if imported_modules(file) & SOCKETS] == []


def test_of_arcl_only_the_transports_know_sockets():
    with_sockets = {file.name for file in files_of('omron_arcl')
                    if imported_modules(file) & SOCKETS}
    assert with_sockets <= TRANSPORTS


def imported_modules(file: Path) -> Set[str]:
    return {name.split('.')[0] for name in imported_by(file)}


def test_every_layer_is_there():
    assert [layer for layer in ALLOWED if not list(files_of(layer))] == []
