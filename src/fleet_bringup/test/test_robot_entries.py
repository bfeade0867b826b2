"""The settings for the start of robots in a fleet file."""
from __future__ import annotations

import pytest
from bringup_builders import entries

from fleet_core.files.errors import FileError


def test_simulated_robots_get_ports_ten_apart(tmp_path):
    found = entries(tmp_path, 'name: a, type: ld90, vertex: 6, driver: ld90',
                    'name: b, type: agv, vertex: 8, driver: agv',
                    'name: c, type: ld90, vertex: 18, driver: ld90, start: [1, 2, 90]')
    assert [(one.arcl_port, one.outgoing_port) for one in found] == [
        (7171, 7179), (0, 0), (7181, 7189)]
    assert found[2].start == (1.0, 2.0, 90.0)


def test_a_real_robot_is_told_by_its_host(tmp_path):
    (tmp_path / 'secret').write_text('word')
    real, other = entries(
        tmp_path,
        'name: a, type: ld90, vertex: 6, driver: ld90, host: 10.0.0.5, password_file: secret',
        'name: b, type: agv, vertex: 8, driver: none')
    assert (real.is_simulated, real.host, real.arcl_port) == (False, '10.0.0.5', 7171)
    assert real.password_file == str(tmp_path / 'secret')
    assert not other.is_simulated


def test_nothing_is_started_for_a_robot_with_a_computer_of_its_own(tmp_path):
    elsewhere, = entries(tmp_path, 'name: a, type: ld90, vertex: 6, driver: ld90, '
                         'computer: 10.0.0.21')
    assert (elsewhere.computer, elsewhere.is_simulated, elsewhere.robot.driver) == (
        '10.0.0.21', False, 'none')


@pytest.mark.parametrize('robots, line, problem', [
    (['name: a, type: agv, vertex: 6, driver: agv, computer: 10.0.0.21'], 6,
     'with a computer of its own its driver is ld90 or none'),
    (['name: a, type: ld90, vertex: 6, driver: ld90, computer: 10.0.0.321'], 6,
     'must be the IPv4 address or the name'),
    (['name: a, type: agv, vertex: 6, drivr: agv'], 6, "key 'drivr' .* did you mean driver?"),
    (['name: a, typ: agv, vertex: 6, driver: agv'], 6, "key 'typ' .* did you mean type[?]$"),
    (['name: a, type: agv, vertex: 6'], 6, 'driver is missing'),
    (['name: a, type: agv, vertex: 6, driver: bus'], 6, 'must be ld90 or agv or none'),
    (['name: a-1, type: agv, vertex: 6, driver: agv'], 6, 'letters, digits and _'),
    (['name: a, type: agv, vertex: 6, driver: agv, host: 10.0.0.5'], 6, 'for driver ld90 only'),
    (['name: a, type: ld90, vertex: 6, driver: ld90, host: 10.0.0.5'], 6, 'no password_file'),
    (['name: a, type: ld90, vertex: 6, driver: ld90, host: h, password_file: gone'], 6,
     'cannot be read'),
    (['name: a, type: ld90, vertex: 6, driver: ld90, start: [1, 2]'], 6, 'start must be a list'),
    (['name: a, type: ld90, vertex: 6, driver: ld90',
      'name: b, type: ld90, vertex: 8, driver: ld90, arcl_port: 7171'], 7,
     r'robots a \(line 6\) and b have the same ARCL port 7171 of 127.0.0.1'),
    (['name: a, type: ld90, vertex: 6, driver: ld90',
      'name: b, type: ld90, vertex: 8, driver: ld90, outgoing_port: 7179'], 7,
     'the same outgoing_port 7179'),
    (['name: a, type: ld90, vertex: 6, driver: ld90', 'name: b, type: agv, vertex: 6, driver: agv'],
     7, r'robots a \(line 6\) and b have the same vertex 6'),
])
def test_what_is_wrong_is_named_with_its_line(tmp_path, robots, line, problem):
    with pytest.raises(FileError, match=problem) as caught:
        entries(tmp_path, *robots)
    assert caught.value.line == line


def test_two_robots_at_one_address_are_told(tmp_path):
    (tmp_path / 'secret').write_text('word')
    robot = 'type: ld90, driver: ld90, host: 10.0.0.5, password_file: secret'
    with pytest.raises(FileError, match='have the same host 10.0.0.5'):
        entries(tmp_path, f'name: a, vertex: 6, {robot}', f'name: b, vertex: 8, {robot}')
