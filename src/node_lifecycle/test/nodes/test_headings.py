"""Headings and quaternions, as all nodes convert them."""
from __future__ import annotations

import ast
import math
from pathlib import Path

import pytest
from geometry_msgs.msg import Quaternion

from node_lifecycle.headings import quaternion_from_yaw, yaw_from_quaternion

SOURCES = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize('yaw', [0.0, 1.0, -1.0, math.pi / 2.0, 3.1, -3.1])
@pytest.mark.parametrize('turns', [0, 1, -1])
def test_a_heading_comes_back_from_its_quaternion(yaw, turns):
    turn = quaternion_from_yaw(yaw + turns * 2.0 * math.pi)
    assert yaw_from_quaternion(turn) == pytest.approx(yaw)
    opposite = Quaternion(-turn.x, -turn.y, -turn.z, -turn.w)  # the same rotation
    assert yaw_from_quaternion(opposite) == pytest.approx(yaw)


def test_roll_and_pitch_do_not_change_the_heading():
    roll = 0.2
    assert yaw_from_quaternion(Quaternion(  # a roll, then a yaw of 90 degrees
        math.sin(roll / 2.0) * math.sqrt(0.5), math.sin(roll / 2.0) * math.sqrt(0.5),
        math.cos(roll / 2.0) * math.sqrt(0.5), math.cos(roll / 2.0) * math.sqrt(0.5)
    )) == pytest.approx(math.pi / 2.0)


def test_only_one_module_of_the_workspace_makes_quaternions():
    makers = {file.name for file in SOURCES.glob('*/src/**/*.py')
              for node in ast.walk(ast.parse(file.read_bytes()))
              if isinstance(node, ast.Call) and getattr(node.func, 'id', '') == 'Quaternion'}
    assert makers == {'headings.py'}
