"""Whatever bytes a client sends, the robot continues and answers in whole lines."""
from __future__ import annotations

import contextlib
import math
from dataclasses import astuple
from typing import List

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from sim_builders import Rig

from omron_ld90_sim.interface.commands import TABLE
from omron_ld90_sim.interface.faults import Faults, NoSuchFault, help_text

NUMBERS = ['-1', '0', '0.5', '90', '4294967296', '-1e12', '1e308', '1e400', 'nan', '-inf']
WORDS = [*NUMBERS, '12', 'West', '"East side"', '"', '""',
         '"open', '$X', '$g$', 'Round', 'Greeting', 'Laser_1', 'move', 'wait', 'goto', 'gotoPoint',
         'deltaHeading', 'setHeading', 'localizeAtGoal', 'say', 'pause', 'movementParametersTemp',
         'Section', 'Files', 'Docking', 'AutoDock', 'true', '../x.map', '\x00', '\t', 'Goal', '|']
ENDING = {'shutdown', 'quit', 'extioremove'}  # commands that end the connection
NAMES = sorted(name for name in {row.name for row in TABLE.values()} if name.lower() not in ENDING)
LINES = st.builds(lambda name, words: ' '.join([name, *words]), st.sampled_from(NAMES),
                  st.lists(st.sampled_from(WORDS), max_size=5))
FAULTS = [line.split()[0] for line in help_text().splitlines()]
RIG = Rig()  # one robot for all examples: the effects of earlier examples are part of the test


@settings(max_examples=3 * settings.default.max_examples)
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


@given(name=st.sampled_from(FAULTS), words=st.lists(st.sampled_from(NUMBERS), max_size=3),
       seconds=st.sampled_from(['', *NUMBERS]))
@example(name='lost', words=['nan', '0', '0'], seconds='')
def test_no_number_in_a_fault_breaks_the_robot(name: str, words: List[str], seconds: str) -> None:
    rig = Rig()
    client = rig.client()
    with contextlib.suppress(NoSuchFault):
        Faults(rig.server).schedule(' '.join([seconds, name, *words]).strip())
    client.send('goto 12', 'status', 'rangeDeviceGetCurrent Laser_1')
    rig.clock.advance(5.0)
    client.send('status', 'oneLineStatus', 'localizeAtGoal 12')
    rig.clock.advance(10.0)
    assert math.isfinite(rig.clock.now) and math.isfinite(sum(astuple(rig.robot.pose)))


@settings(max_examples=2 * settings.default.max_examples)
@given(st.lists(st.binary(max_size=40), max_size=10))
def test_no_bytes_break_the_server(chunks: List[bytes]) -> None:
    session = RIG.server.connect()
    for chunk in chunks:
        session.receive(chunk)
    client = RIG.client()
    client.session.receive(b''.join(chunks) + b'\n')
    RIG.clock.advance(RIG.clock.now + 0.3)
    assert client.session.closed or bytes(client.session.output[-2:]) in (b'\r\n', b'\n\r', b'')
    for each in (session, client.session):
        each.close()
