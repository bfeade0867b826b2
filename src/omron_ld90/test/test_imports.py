"""Each module can be imported under this Python version, and there are no circular imports.

If ROS is not installed, a module that needs ROS is only compiled.
"""
from __future__ import annotations

import ast
import re
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Dict, Iterable, List, Set

import pytest
from proofs import names_imported

SOURCES = Path(__file__).resolve().parents[2]
PACKAGES = [file.parent for file in sorted(SOURCES.glob('*/src/*/__init__.py'))]
COMES_WITH_ROS = ('rospy', 'rosgraph', 'rosmaster', 'rospkg', 'roslib', 'roslaunch', 'genpy',
                  'actionlib', 'diagnostic_updater', 'interactive_markers', 'std_srvs', 'tf2_ros',
                  'PyQt5')


@pytest.mark.every_python
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
    """Returns the modules of the workspace that a module imports, even if only for annotations."""
    names: Set[str] = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{file}: a relative import'
            members = {f'{node.module}.{alias.name}' for alias in node.names}
            names |= members & set(MODULES) or {str(node.module)}
    return names & set(MODULES)


def in_circles(imports: Dict[str, Set[str]]) -> Set[str]:
    """Returns the modules of import circles, and the modules between two circles."""
    left = set(imports)
    while True:
        used = {name for module in left for name in imports[module]}
        inner = {module for module in left if module in used and imports[module] & left}
        if inner == left:
            return left
        left = inner


def test_imports_run_in_no_circle():
    assert in_circles({module: imported(file) - {module}
                       for module, file in MODULES.items()}) == set()


def test_a_circle_of_imports_is_found():
    imports = {'a': {'b'}, 'b': {'c'}, 'c': {'a', 'e'}, 'd': {'a'}, 'e': set()}
    assert in_circles(imports) == {'a', 'b', 'c'}


# -- what is imported is declared in package.xml ---------------------------------------------------

FOLDERS = sorted(file.parent for file in SOURCES.glob('*/package.xml'))
DEBIAN = {
    'PIL': 'pil', 'PyQt5': 'pyqt5', 'aiohttp': 'aiohttp', 'hypothesis': 'hypothesis',
    'jsonschema': 'jsonschema', 'networkx': 'networkx', 'numpy': 'numpy', 'paho': 'paho-mqtt',
    'pymodbus': 'pymodbus', 'pytest': 'pytest', 'rospkg': 'rospkg', 'scipy': 'scipy',
    'shapely': 'shapely', 'skimage': 'skimage', 'yaml': 'yaml'}
"""Module of a library: name of its package in Debian, without `python3-`."""
PARTS = {'yarl': 'aiohttp'}
"""Module: module of the library to which it belongs."""
WITHOUT = {'selenium', 'vda5050'}
"""Libraries without which tests skip."""
HELPERS = {file.stem for file in (SOURCES.parent / 'test').glob('*.py')}
"""Modules for the system tests; they are in no package."""


def modules_of_tests(folder: Path) -> Dict[str, Path]:
    """Returns the modules in the test folder of a package by name, such as `world.chaos`."""
    found: Dict[str, Path] = {}
    for file in sorted((folder / 'test').rglob('*.py')):
        is_in_package = (file.parent / '__init__.py').exists()
        found[f'{file.parent.name}.{file.stem}' if is_in_package else file.stem] = file
    return found


TESTS = {folder.name: modules_of_tests(folder) for folder in FOLDERS}
HOMES = {package.name: package.parents[1].name for package in PACKAGES}
HOMES.update({file.stem: file.relative_to(SOURCES).parts[0] for file in SOURCES.glob('*/src/*.py')})


def needed(files: Iterable[Path], folder: str) -> Set[str]:
    """Returns what package.xml has to declare for these files of a package.

    The builders of other packages that the files import also count. Dependencies that another
    package has outside its tests need not be declared again.
    """
    found: Set[str] = set()
    todo, done = list(files), set()
    while todo:
        file = todo.pop()
        done.add(file)
        home = file.relative_to(SOURCES).parts[0]
        comes_with_it = set() if home == folder else declared(SOURCES / home, NORMAL)
        for name in names_imported(file):
            top = name.split('.')[0]
            owners = [home] if name in TESTS[home] else [
                one for one, modules in TESTS.items() if name in modules and top not in HOMES]
            todo += [TESTS[one][name] for one in owners if TESTS[one][name] not in done]
            found |= set(owners or [declared_as(top)]) - comes_with_it
    return found - {folder, ''}


def declared_as(top: str) -> str:
    """Returns the name with which package.xml declares a module; empty: Python has the module."""
    if top in HOMES:
        return HOMES[top]
    if top in COMES_WITH_ROS and top not in DEBIAN or top.endswith('_msgs'):
        return top
    top = PARTS.get(top, top)
    return f'python3-{DEBIAN[top]}' if top in DEBIAN else ''


NORMAL, TESTING = 'depend|exec_depend', 'depend|exec_depend|test_depend'


def declared(folder: Path, kinds: str) -> Set[str]:
    return set(re.findall(rf'<(?:{kinds})>([\w-]+)<', (folder / 'package.xml').read_text()))


@pytest.mark.parametrize('package', PACKAGES, ids=lambda package: package.name)
def test_a_package_declares_what_it_imports(package: Path):
    folder = package.parents[1]
    assert needed(package.rglob('*.py'), folder.name) - declared(folder, NORMAL) == set()


@pytest.mark.parametrize('folder', FOLDERS, ids=lambda folder: folder.name)
def test_a_package_declares_what_its_tests_import(folder: Path):
    """So the tests of a package run in a workspace that has only what the package declares."""
    assert needed(TESTS[folder.name].values(), folder.name) - declared(folder, TESTING) == set()


@pytest.mark.skipif(sys.version_info < (3, 10), reason='Python does not name its modules')
def test_each_imported_module_has_an_owner():
    known = {*sys.stdlib_module_names, *HOMES, *DEBIAN, *PARTS, *WITHOUT, *COMES_WITH_ROS, *HELPERS,
             *(name.split('.')[0] for modules in TESTS.values() for name in modules)}
    files = [file for folder in FOLDERS for kind in ('src', 'test')
             for file in (folder / kind).rglob('*.py')]
    strange = {name.split('.')[0] for file in files for name in names_imported(file)} - known
    assert {name for name in strange if not name.endswith('_msgs')} == set()


@pytest.mark.parametrize('file', sorted(SOURCES.glob('*/package.xml')),
                         ids=lambda file: file.parent.name)
def test_a_package_declares_each_dependency_once(file: Path):
    declared = re.findall(r'<(\w*depend)[^>]*>([\w-]+)<', file.read_text())
    assert sorted(set(declared)) == sorted(declared)


def test_some_package_declares_each_library_that_the_scripts_install():
    """The Debian packages of this workspace, and rosdep, install only what is declared."""
    table = re.search(r'^run_packages=\(\n(.*?)^\)', (
        SOURCES.parent / 'scripts/common.sh').read_text(), re.DOTALL | re.MULTILINE)
    assert table is not None
    libraries = {name for name in re.findall(r'\s([\w.-]+)"$', table.group(1), re.MULTILINE)
                 if not name.startswith('ros-noetic-')}
    declared_here = {name for folder in FOLDERS for name in re.findall(
        r'depend[^>]*>([\w.-]+)<', (folder / 'package.xml').read_text())}
    assert libraries - declared_here == {'build-essential'}  # catkin itself needs it
