"""A misspelt key of a fleet file is an error, because the right key might keep robots apart."""
from __future__ import annotations

from pathlib import Path

import pytest

from fleet_core.files.errors import FileError
from fleet_core.files.fleet_file import load_fleet
from fleet_core.files.robot_settings import load_settings

# -- keys ------------------------------------------------------------------------------------------

KEYS = """clearance: 0.1
robot_types:
- {name: truck, radius: 0.4, speed: 1.0, play: 0.25, slack: 0.3}
robots:
- {name: truck_1, type: truck, vertex: 1, absent: true}
"""


@pytest.mark.parametrize('text', [KEYS, KEYS.replace('slack: 0.3', 'slack: 0.3, stopping: 3.5')])
def test_what_is_spelt_right_is_read_also_a_key_of_1_0_0(tmp_path, text):
    (tmp_path / 'fleet.yaml').write_text(text)
    fleet = load_fleet(tmp_path / 'fleet.yaml')
    assert fleet.types[0].play == 0.25 and fleet.robots[0].absent


@pytest.mark.parametrize('right, wrong, known', [
    ('play:', 'plya:', 'did you mean play?'), ('slack:', 'slak:', 'did you mean slack?'),
    ('absent:', 'abscent:', 'did you mean absent?'), ('clearance:', 'clearence:', 'clearance?')])
def test_a_misspelt_key_is_named(tmp_path, right, wrong, known):
    (tmp_path / 'fleet.yaml').write_text(KEYS.replace(right, wrong))
    with pytest.raises(FileError) as error:
        load_fleet(tmp_path / 'fleet.yaml')
    assert wrong[:-1] in str(error.value) and known in str(error.value)


@pytest.mark.parametrize('right, wrong, sentence', [
    ('play: 0.25', 'play: 0,25', 'line 3: a robot type has a number, 25, where the name of a field '
     'must be; write decimal numbers with a point'),
    ('absent: true', 'absent: ', 'line 5: absent has no value'),
    ('absent: true', 'absent', 'line 5: absent has no value')])
def test_a_key_without_a_value_and_a_key_that_is_a_number_are_refused_with_their_line(
        tmp_path, right, wrong, sentence):
    (tmp_path / 'fleet.yaml').write_text(KEYS.replace(right, wrong))
    with pytest.raises(FileError) as error:
        load_fleet(tmp_path / 'fleet.yaml')
    assert sentence in str(error.value)


# -- the settings of the supervisor ----------------------------------------------------------------

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
