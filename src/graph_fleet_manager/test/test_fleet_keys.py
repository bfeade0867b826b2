"""A misspelt key of a fleet file is an error, because it could be one that keeps robots apart."""
from __future__ import annotations

import pytest

from graph_fleet_manager.files.errors import FileError
from graph_fleet_manager.files.fleet_file import load_fleet

FLEET = """clearance: 0.1
robot_types:
- {name: truck, radius: 0.4, speed: 1.0, play: 0.25, stopping: 3.5}
robots:
- {name: truck_1, type: truck, vertex: 1, absent: true}
"""


def test_what_is_spelt_right_is_read(tmp_path):
    (tmp_path / 'fleet.yaml').write_text(FLEET)
    fleet = load_fleet(tmp_path / 'fleet.yaml')
    assert fleet.types[0].play == 0.25 and fleet.robots[0].absent


@pytest.mark.parametrize('right, wrong, known', [
    ('play:', 'plya:', 'did you mean play?'), ('stopping:', 'stoping:', 'did you mean stopping?'),
    ('absent:', 'abscent:', 'did you mean absent?'), ('clearance:', 'clearence:', 'clearance?')])
def test_a_misspelt_key_is_named(tmp_path, right, wrong, known):
    (tmp_path / 'fleet.yaml').write_text(FLEET.replace(right, wrong))
    with pytest.raises(FileError) as error:
        load_fleet(tmp_path / 'fleet.yaml')
    assert wrong[:-1] in str(error.value) and known in str(error.value)
