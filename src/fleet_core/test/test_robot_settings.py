"""The settings of the supervisor in the fleet file."""
from __future__ import annotations

from pathlib import Path

import pytest

from fleet_core.files.errors import FileError
from fleet_core.files.fleet_file import load_fleet
from fleet_core.files.robot_settings import load_settings

LAB = Path(__file__).resolve().parents[3] / 'maps' / 'lab_fleet.yaml'
FLEET = '''
clearance: 0.1
robot_types:
- {name: agv, radius: 0.4, speed: 1.0, release_ahead: 0.0, charge_below: 0.2}
robots:
- {name: a, type: agv, vertex: 1}
- {name: b, type: agv, vertex: 2, charge_below: 0.4}
'''


def test_the_laboratory_has_one_robot_named_as_full_stack_names_it():
    robot, = load_fleet(LAB).robots
    assert robot.name == 'omron_ld90' and robot.type.docks == frozenset({16})
    assert load_settings(LAB)['omron_ld90'].release_ahead == 8.0


def test_what_a_robot_says_goes_before_what_its_type_says(tmp_path):
    file = tmp_path / 'fleet.yaml'
    file.write_text(FLEET)
    settings = load_settings(file)
    assert (settings['a'].release_ahead, settings['a'].charge_below) == (0.0, 0.2)
    assert (settings['b'].release_ahead, settings['b'].charge_below) == (0.0, 0.4)
    assert settings['a'].leave_above == 0.8


@pytest.mark.parametrize('wrong, reason', [
    ('charge_below: 30', r'line 7: charge_below is 30.0, but must be a number from 0 to 1'),
    ('release_ahead: .nan', 'release_ahead is nan'), ('slack: -1', 'slack is -1'),
    ('leave_above: 0.1', 'leave_above is less than charge_below')])
def test_a_wrong_number_is_named_with_its_line(tmp_path, wrong, reason):
    file = tmp_path / 'fleet.yaml'
    file.write_text(FLEET.replace('charge_below: 0.4', wrong))
    with pytest.raises(FileError, match=reason):
        load_settings(file)
