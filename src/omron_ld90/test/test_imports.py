"""Each module can be imported under this Python version, and there are no circular imports.

If ROS is not installed, a module that needs it is only compiled.
"""
from __future__ import annotations

import ast
import re
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Dict, List, Set

import pytest

SOURCES = Path(__file__).resolve().parents[2]
PACKAGES = [file.parent for file in sorted(SOURCES.glob('*/src/*/__init__.py'))]
COMES_WITH_ROS = ('rospy', 'rosgraph', 'rospkg', 'roslib', 'roslaunch', 'genpy', 'actionlib',
                  'diagnostic_updater', 'interactive_markers', 'tf2_ros', 'PyQt5')

pytestmark = pytest.mark.every_python


@pytest.mark.parametrize('package', PACKAGES, ids=lambda package: package.name)
def test_every_module_of_a_package_can_be_imported(package: Path):
    failed: List[str] = []
    for file in sorted(package.rglob('*.py')):
        compile(file.read_bytes(), str(file), 'exec')
        module = '.'.join(file.relative_to(package.parent).with_suffix('').parts)
        try:
            import_module(module[:-len('.__init__')] if file.stem == '__init__' else module)
        except ModuleNotFoundError as error:
            if not is_of_missing_ros(error.name or ''):
                failed.append(f'{module}: {error}')
    assert failed == []


def is_of_missing_ros(module: str) -> bool:
    top = module.split('.')[0]
    return find_spec('rospy') is None and (top in COMES_WITH_ROS or top.endswith('_msgs'))


def test_every_package_is_there():
    assert {package.parents[1].name for package in PACKAGES} == {
        folder.parent.name for folder in SOURCES.glob('*/setup.py')}


def module_of(file: Path, package: Path) -> str:
    return re.sub(r'\.__init__$', '', '.'.join(
        file.relative_to(package.parent).with_suffix('').parts))


MODULES = {module_of(file, package): file
           for package in PACKAGES for file in package.rglob('*.py')}


def imported(file: Path) -> Set[str]:
    """Modules of the workspace that a module imports, also only for type annotations."""
    names: Set[str] = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{file}: a relative import'
            members = {f'{node.module}.{alias.name}' for alias in node.names}
            names |= members & set(MODULES) or {str(node.module)}
    return names & set(MODULES)


IMPORTS = {module: imported(file) for module, file in MODULES.items()}


def in_circles(imports: Dict[str, Set[str]]) -> Set[str]:
    """The modules of import circles, and modules between two circles."""
    left = set(imports)
    while True:
        used = {name for module in left for name in imports[module]}
        inner = {module for module in left if module in used and imports[module] & left}
        if inner == left:
            return left
        left = inner


def test_imports_run_in_no_circle():
    assert in_circles({module: names - {module} for module, names in IMPORTS.items()}) == set()


def test_a_circle_of_imports_is_found():
    imports = {'a': {'b'}, 'b': {'c'}, 'c': {'a', 'e'}, 'd': {'a'}, 'e': set()}
    assert in_circles(imports) == {'a', 'b', 'c'}


@pytest.mark.parametrize('package', PACKAGES, ids=lambda package: package.name)
def test_a_package_declares_what_it_imports(package: Path):
    source = package.parents[1]
    declared = set(re.findall(r'<(?:exec_)?depend>(\w+)<', (source / 'package.xml').read_text()))
    owners = {MODULES[name].relative_to(SOURCES).parts[0]
              for file in package.rglob('*.py') for name in IMPORTS[module_of(file, package)]}
    assert owners - {source.name} <= declared


@pytest.mark.parametrize('file', sorted(SOURCES.glob('*/package.xml')),
                         ids=lambda file: file.parent.name)
def test_a_package_declares_each_dependency_once(file: Path):
    declared = re.findall(r'<(\w*depend)[^>]*>([\w-]+)<', file.read_text())
    assert sorted(set(declared)) == sorted(declared)
