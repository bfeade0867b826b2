"""A misspelt key of a fleet file is an error, because it could be one that keeps robots apart."""
from __future__ import annotations

import pytest

from fleet_core.files.errors import FileError
from fleet_core.files.fleet_file import load_fleet

FLEET = """clearance: 0.1
robot_types:
- {name: truck, radius: 0.4, speed: 1.0, play: 0.25, slack: 0.3}
robots:
- {name: truck_1, type: truck, vertex: 1, absent: true}
"""


@pytest.mark.parametrize('text', [FLEET, FLEET.replace('slack: 0.3', 'slack: 0.3, stopping: 3.5')])
def test_what_is_spelt_right_is_read_also_a_key_of_1_0_0(tmp_path, text):
    (tmp_path / 'fleet.yaml').write_text(text)
    fleet = load_fleet(tmp_path / 'fleet.yaml')
    assert fleet.types[0].play == 0.25 and fleet.robots[0].absent


@pytest.mark.parametrize('right, wrong, known', [
    ('play:', 'plya:', 'did you mean play?'), ('slack:', 'slak:', 'did you mean slack?'),
    ('absent:', 'abscent:', 'did you mean absent?'), ('clearance:', 'clearence:', 'clearance?')])
def test_a_misspelt_key_is_named(tmp_path, right, wrong, known):
    (tmp_path / 'fleet.yaml').write_text(FLEET.replace(right, wrong))
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
    (tmp_path / 'fleet.yaml').write_text(FLEET.replace(right, wrong))
    with pytest.raises(FileError) as error:
        load_fleet(tmp_path / 'fleet.yaml')
    assert sentence in str(error.value)
