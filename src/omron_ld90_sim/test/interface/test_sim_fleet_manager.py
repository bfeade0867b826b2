"""The simulated Fleet Manager over TCP, with a simulated robot: lines of OMRON's manual."""
from __future__ import annotations

import re
import socket
import time
from pathlib import Path
from typing import Iterator, List

import pytest

from omron_ld90_sim.interface.simulator import Simulator

MAP = Path(__file__).resolve().parents[4] / 'maps' / 'lab.map'
STATES = ('Pending None', 'InProgress UnAllocated', 'InProgress Allocated', 'InProgress Driving',
          'Completed None')


class Program:
    """A program that gives jobs."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(('127.0.0.1', port), timeout=30.0)
        self._lines = self._socket.makefile('r', newline='\r\n')
        self.say('adept')
        self.until('End of commands')

    def say(self, line: str) -> None:
        self._socket.sendall(line.encode() + b'\n')

    def until(self, words: str) -> List[str]:
        """Returns the lines up to the first one that contains these words."""
        found: List[str] = []
        end = time.monotonic() + 60.0
        while time.monotonic() < end:
            found.append(self._lines.readline().rstrip('\r\n'))
            if words in found[-1]:
                return found
        raise AssertionError(f'{words} did not come: {found}')

    def close(self) -> None:
        self._lines.close()
        self._socket.close()


@pytest.fixture
def program() -> Iterator[Program]:
    with Simulator(MAP, speed=20.0) as simulator:
        found = Program(simulator.manage_on(0, 'adept'))
        yield found
        found.close()


def test_a_robot_serves_a_pickup_and_its_drop_off(program: Program) -> None:
    program.say('queuePickupDropoff 18 20 default 30 abc')
    first, *updates = program.until('DROPOFF2 abc 30 Completed')
    assert first == ('queuepickupdropoff goals "18" and "20" with priorities 10 and 30 ids PICKUP1 '
                     'and DROPOFF2 job_id abc successfully queued')
    assert re.fullmatch(
        r'QueueUpdate: PICKUP1 abc 10 Pending None Goal "18" "None" '
        r'\d\d/\d\d/\d{4} \d\d:\d\d:\d\d None None 0', updates[0])
    told = [' '.join(line.split()[4:6]) for line in updates if ' PICKUP1 ' in line]
    assert told == list(STATES)
    program.say('queueQuery jobId abc')
    answer = program.until('EndQueueQuery')
    assert [line.split()[1:6] for line in answer[:-1]] == [
        ['DROPOFF2', 'abc', '30', 'Completed', 'None'],
        ['PICKUP1', 'abc', '10', 'Completed', 'None']]


def test_an_unknown_goal_and_a_double_id_are_errors(program: Program) -> None:
    program.say('queuePickup nowhere')
    assert program.until('CommandErrorDescription')[-2:] == [
        'CommandError: queuePickup nowhere',
        'CommandErrorDescription: queuePickup no such goal "nowhere"']
    program.say('queuePickup 18 default abc')
    program.until('successfully queued')
    program.say('queuePickup 20 default ABC')
    assert 'is that of an active job' in program.until('CommandErrorDescription')[-1]


def test_a_drive_that_is_cancelled_ends(program: Program) -> None:
    program.say('queueMulti 2 2 18 pickup default 20 dropoff default abc')
    program.until('PICKUP1 abc 10 InProgress Driving')
    program.say('queueCancel jobId abc default late')
    lines = program.until('DROPOFF2 abc 20 Cancelled')
    assert [' '.join(line.split()[4:6]) for line in lines if ' PICKUP1 ' in line] == [
        'Cancelling late', 'Interrupted None', 'Cancelled late']


def states_of(lines: List[str], segment: str) -> List[str]:
    return [' '.join(line.split()[4:6]) for line in lines
            if line.startswith(f'QueueUpdate: {segment} ')]


def test_a_pickup_where_a_running_job_drops_off_is_a_swap(program: Program) -> None:
    program.say('queuePickupDropoff 18 20 default default first')
    program.until('PICKUP1 first 10 InProgress Driving')
    program.say('queuePickupDropoff 20 18 default default second')
    lines = program.until('DROPOFF4 second 20 Completed')
    assert next(line for line in lines if line.startswith('queuepickupdropoff')) == (
        'queuepickupdropoff goals "20" and "18" with priorities 10 and 20 ids PICKUP3 and DROPOFF4 '
        'job_id second successfully queued and linked to job_id first')
    assert states_of(lines, 'PICKUP3') == ['Pending ID_DROPOFF2', *STATES[1:]]
    first, second = [line for line in lines if 'DROPOFF2 first 20 Completed' in line
                     or 'PICKUP3 second 10 Completed' in line]
    assert first.split()[-3:-1] == second.split()[-3:-1], 'not in the same second'
    robots = {line.split()[8] for line in lines if line.startswith('QueueUpdate: PICKUP3')}
    assert len(robots) == 1 and '"None"' not in robots


def test_another_goal_of_a_drop_off_parts_a_swap(program: Program) -> None:
    program.say('queuePickupDropoff 18 20 default default first')
    program.until('PICKUP1 first 10 InProgress Driving')
    program.say('queuePickupDropoff 20 18 default default second')
    program.until('successfully queued and linked to job_id first')
    program.say('queueModify DROPOFF2 goal 18')
    lines = program.until('DROPOFF4 second 20 Completed')
    assert states_of(lines, 'DROPOFF2')[-3:] == list(STATES[2:])
    assert any('QueueUpdate: PICKUP3 second 10 Pending None Goal "20" "None"' in line
               for line in lines)


def test_a_pending_segment_gets_another_priority_and_a_driven_one_another_goal(
        program: Program) -> None:
    program.say('queuePickupDropoff 18 20 default default abc')
    program.until('PICKUP1 abc 10 InProgress Driving')
    program.say('queueModify dropoff2 priority 6')
    lines = program.until('DROPOFF2 abc 6 Pending')
    assert 'queuemodify modifying id dropoff2 priority 6' in lines
    assert states_of(lines, 'DROPOFF2')[-3:] == [
        'BeforeModify None', 'AfterModify None', 'Pending ID_PICKUP1']
    program.say('queueModify PICKUP1 goal 20')
    lines = program.until('PICKUP1 abc 10 Completed')
    assert 'queuemodify modifying id PICKUP1 goal "20"' in lines
    assert states_of(lines, 'PICKUP1') == [
        'BeforeModify Driving', 'InterruptedByModify None', 'AfterModify None', *STATES]
    program.until('DROPOFF2 abc 6 Completed')
    program.say('queueModify PICKUP1 goal 18')
    assert program.until('CommandErrorDescription')[-2:] == [
        'CommandError: queueModify PICKUP1 goal 18',
        'CommandErrorDescription: queueModify no segment "PICKUP1" that can be modified']
