"""Runs of the whole program over sockets: the results that the seed determines."""
from __future__ import annotations

import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import List

from sim_builders import ROOM, Rig

from omron_ld90_sim.interface.recording import Transfer, read_log

PROGRAM = [sys.executable, '-c',
           'import sys; from omron_ld90_sim.interface.cli import main; sys.exit(main())']
BEGIN = 10.0  # s on the robot's clock; on any computer the connection exists by then


def recorded_drive(folder: Path, seed: int) -> List[Transfer]:
    """Returns the part of the program's log about a drive. The drive begins at a known time."""
    folder.mkdir()
    room, log = folder / 'room.map', folder / 'session.log'
    room.write_text(ROOM)
    with socket.socket() as listener:
        listener.bind(('127.0.0.1', 0))
        listener.listen(1)
        listener.settimeout(20.0)
        program = subprocess.Popen(
            [*PROGRAM, '--map', str(room), '--port', '0', '--speed', '20', '--seed', str(seed),
             '--start', '-3.0,1.5,0', '--log', str(log), '--fault', f'{BEGIN} other goto 12',
             '--outgoing', '{}:{}'.format(*listener.getsockname())], stdout=subprocess.DEVNULL)
        try:
            link, _ = listener.accept()
            link.settimeout(20.0)
            with link, link.makefile('r', encoding='ascii') as lines:
                for line in lines:
                    if line.startswith('Arrived at 12'):
                        break
            program.terminate()
            assert program.wait(10.0) == 0
        finally:
            program.kill()
            program.wait()
    transfers = [transfer for transfer in read_log(log.read_text().splitlines())
                 if transfer.time >= BEGIN]
    end = next(n for n, transfer in enumerate(transfers) if transfer.text == 'Arrived at 12')
    return transfers[:end + 1]


def test_two_runs_of_the_program_with_one_seed_write_the_same_log(tmp_path: Path) -> None:
    seeds = (7, 7, 8)
    folders = [tmp_path / str(number) for number in range(len(seeds))]
    with ThreadPoolExecutor(len(seeds)) as pool:
        first, again, other = pool.map(recorded_drive, folders, seeds)
    assert len([each for each in first if each.text.startswith('RangeDeviceGetCurrent')]) > 20
    assert first == again
    assert first != other, 'another seed must change the log'


def test_a_client_that_asks_often_does_not_change_what_the_robot_does() -> None:
    ends = []
    for questions in (0, 25):
        rig = Rig(seed=3, arrival_error=(30.0, 1.0))
        client = rig.client()
        for _ in range(questions):
            client.send('status', 'rangeDeviceGetCurrent Laser_1')
        client.send('goto "East side"')
        client.until('Arrived')
        ends.append((rig.robot.true_pose, client.ask('status')))
    assert ends[0] == ends[1]
