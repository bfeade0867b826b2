"""A simulation in this process: its map, its robots, its end."""
from __future__ import annotations

import socket
import time
from contextlib import closing
from pathlib import Path

import pytest
from sim_builders import ROOM
from sim_client import Talk

from omron_ld90_sim import Simulator
from omron_ld90_sim.interface.fleet import RobotSpec


def test_a_map_on_the_robot_is_switched_to(map_file: Path) -> None:
    (map_file.parent / 'other.map').write_text(ROOM.replace('"West"', '"Occident"'))
    with Simulator(map_file) as robot, closing(Talk(robot.port)) as client:
        for line in ('configStart', 'configAdd Section Files', 'configAdd Map other.map',
                     'configParse'):
            client.send(line)
        assert client.until('Config ')[-4:] == ['Will parse config', 'Map changed',
                                                'Configuration changed', 'Config parsed fine']
        client.send('getGoals')
        assert 'Goal: Occident' in client.until('End of goals')
        for line in ('configStart', 'configAdd Section Files', 'configAdd Map ../room.map',
                     'configParse'):
            client.send(line)
        assert 'did not exist' in client.until('Config had')[-1]


def test_a_fleet_runs_in_one_process(map_file: Path) -> None:
    robots = [RobotSpec('a', 0), RobotSpec('b', 0), RobotSpec('c', 0, start=(0.0, 2000.0, 90.0))]
    with Simulator(map_file, speed=20.0, robots=robots) as fleet:
        talks = {name: Talk(port) for name, port in fleet.ports.items()}
        places = {(round(u.robot.true_pose.x), round(u.robot.true_pose.y)) for u in fleet.units}
        assert len(places) == 3 and (0, 2000) in places
        assert list(fleet.where()['robots']) == ['a', 'b', 'c']
        assert fleet.where()['robots']['c'] == {
            'x': 0.0, 'y': 2.0, 'heading': 90.0, 'driven': 0.0}
        fleet.inject('@b estop press')
        talks['b'].until('EStop pressed')
        talks['a'].send('queryMotors')
        assert talks['a'].until('Motors')[-1] == 'Motors enabled'
        for talk in talks.values():
            talk.close()


def test_the_clock_can_be_made_faster_and_slower(map_file: Path) -> None:
    def passes(robot: Simulator, seconds: float) -> float:
        """Returns the real seconds until the robot's clock has advanced by `seconds`."""
        begin, until = time.monotonic(), robot.loop.clock.now + seconds
        while robot.loop.clock.now < until:
            time.sleep(0.001)
        return time.monotonic() - begin

    with Simulator(map_file, speed=0.1) as robot:
        robot.set_speed(20.0)
        before = robot.loop.clock.now
        fast = passes(robot, 6.0)
        robot.set_speed(1.0)
        assert robot.loop.clock.now >= before + 6.0, 'its time must not go back'
        slow = passes(robot, 0.6)
        with pytest.raises(ValueError, match="'0' is not a number from 0.1 to 20"):
            robot.set_speed(0)
    assert fast < 6.0, 'it must take much less than the minute at speed 0.1'
    assert slow > 0.5


def test_a_simulation_that_ends_at_once_leaves_nothing_behind(map_file: Path) -> None:
    for _ in range(5):
        with Simulator(map_file) as robot:
            port = robot.port
        robot.stop()
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(('127.0.0.1', port), timeout=5.0)
