"""Whatever a client sends, the robot goes on and answers in whole ASCII lines."""
from __future__ import annotations

from typing import List

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim_builders import Rig

from omron_ld90_sim.interface.commands import TABLE

WORDS = ['12', 'West', '"East side"', '-1', '0', '1e400', 'nan', '-inf', '99999999999', '"', '""',
         '"open', '$X', '$g$', 'Round', 'Greeting', 'Laser_1', 'move', 'wait', 'goto', 'gotoPoint',
         'deltaHeading', 'setHeading', 'localizeAtGoal', 'say', 'pause', 'movementParametersTemp',
         'Section', 'Files', 'Docking', 'AutoDock', 'true', '../x.map', '\x00', '\t', 'Goal', '|']
ENDING = {'shutdown', 'quit', 'extioremove'}     # those that end the connection
NAMES = sorted(name for name in {row.name for row in TABLE.values()} if name.lower() not in ENDING)
LINES = st.builds(lambda name, words: ' '.join([name, *words]), st.sampled_from(NAMES),
                  st.lists(st.sampled_from(WORDS), max_size=5))
RIG = Rig()     # one robot for all examples: what they leave behind is part of the test


@settings(max_examples=300)
@given(st.lists(LINES, min_size=1, max_size=6))
def test_no_command_line_breaks_the_robot(lines: List[str]) -> None:
    client = RIG.client()
    for line in lines:
        client.send(line)
        RIG.clock.advance(RIG.clock.now + 0.3)
    client.lines()
    assert client.ask('queryMotors') == ['Motors enabled']
    client.session.close()


@pytest.mark.parametrize('task', ['move 0', 'move -0.2', 'move 2147483647', 'move 100 0',
                                  'move 100 -5', 'wait -1', 'setHeading 0',
                                  'deltaHeading 1440 1e9'])
def test_extreme_tasks_come_to_an_end(task: str) -> None:
    rig = Rig()
    client = rig.client()
    client.send(f'doTask {task}')
    rig.clock.advance(120.0)
    assert client.lines()[-1] in (f'Completed doing task {task}', 'Error: Failed to move')
    assert rig.robot.activity is None and rig.robot.base.still


@settings(max_examples=200)
@given(st.lists(st.binary(max_size=40), max_size=10))
def test_no_bytes_break_the_server(chunks: List[bytes]) -> None:
    session = RIG.server.connect()
    for chunk in chunks:
        session.receive(chunk)
    client = RIG.client()
    client.session.receive(b''.join(chunks) + b'\n')
    RIG.clock.advance(RIG.clock.now + 0.3)
    assert client.session.output.isascii()
    for each in (session, client.session):
        each.close()
