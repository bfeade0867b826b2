"""Imports inside the simulator point one way: interface -> behaviour -> devices -> motion."""
from __future__ import annotations

import ast
from pathlib import Path
from typing import Iterator

import pytest

from omron_ld90_sim import clock

HOME = Path(clock.__file__).parent
LAYERS = ['motion', 'devices', 'behaviour', 'interface']  # each may import those on its left
OUTSIDE = {'omron_arcl', 'omron_ld90', 'route_protocol', 'rospy', 'trajectory_graph'}


def imports(file: Path) -> Iterator[str]:
    """The modules that a file imports, as written."""
    for node in ast.walk(ast.parse(file.read_text(encoding='utf-8'))):
        if isinstance(node, ast.ImportFrom):
            yield node.module or ''
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)


@pytest.mark.parametrize('layer', LAYERS)
def test_a_layer_imports_only_itself_and_lower_ones(layer: str) -> None:
    lower = LAYERS[:LAYERS.index(layer) + 1] + ['clock']
    files = list((HOME / layer).rglob('*.py'))
    assert files
    upward = [f'{file.name}: {module}' for file in files for module in imports(file)
              if module.startswith('omron_ld90_sim.') and module.split('.')[1] not in lower]
    assert upward == []


def test_nothing_needs_ros_or_another_package_than_omron_map() -> None:
    assert [f'{file.name}: {module}' for file in HOME.rglob('*.py') for module in imports(file)
            if module.split('.')[0] in OUTSIDE] == []
