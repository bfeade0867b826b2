"""Every module can be imported, whichever Python version runs this.

Where ROS is not installed, a module that needs it is compiled only.
"""
from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import List

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
