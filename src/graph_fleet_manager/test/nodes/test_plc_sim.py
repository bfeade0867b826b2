"""The simulated PLC answers each hand-over in time, and repeats an answer until a status shows it.
"""
from __future__ import annotations

import threading
from typing import Any, List

import pytest

from graph_fleet_manager.nodes import plc_sim
from graph_fleet_manager.nodes.plc_sim import REPEAT, PlcSimulator
from itrci_nav_msgs.msg import MissionCommand, MissionStatus


class Commands:
    """The topic of commands; `is_heard`: a fleet manager subscribes to it."""

    def __init__(self) -> None:
        self.is_heard = True
        self.sent: List[MissionCommand] = []

    def send(self, message: MissionCommand) -> None:
        self.sent.append(message)


class Plc(PlcSimulator):
    """A PLC without ROS. Its hand-overs take 3 s, and the test sets its clock."""

    def __init__(self) -> None:
        self._templates, self._seconds = frozenset({'pallet'}), 3.0
        self._lock, self._waiting, self._commands = threading.Lock(), {}, Commands()
        self.now = 100.0

    def hears(self, **fields: Any) -> None:
        self._on_status(MissionStatus(**{'request_id': 7, 'state': MissionStatus.ACTIVE,
                                         'template': 'pallet', **fields}))

    def answers(self, now: float) -> List[int]:
        """Returns the keys of the steps that the PLC answers at this time."""
        before, self.now = len(self._commands.sent), now
        self._tick()
        return [one.step_key for one in self._commands.sent[before:]]


@pytest.fixture
def plc(monkeypatch: pytest.MonkeyPatch) -> Plc:
    made = Plc()
    monkeypatch.setattr(plc_sim.time, 'monotonic', lambda: made.now)
    monkeypatch.setattr(plc_sim.rospy, 'loginfo', lambda *_: None)
    return made


def test_a_hand_over_is_done_after_its_time(plc: Plc) -> None:
    plc.hears(asks=41)
    assert plc.answers(102.9) == [] and plc.answers(103.0) == [41]
    command, = plc._commands.sent
    assert (command.request_id, command.command, command.answer) == (
        7, MissionCommand.ANSWER, MissionCommand.DONE)


def test_an_answer_is_repeated_until_a_status_shows_that_it_was_taken(plc: Plc) -> None:
    plc.hears(asks=41)
    assert plc.answers(103.0) == [41]
    plc.hears(asks=41)
    assert plc.answers(103.1) == [] and plc.answers(103.0 + REPEAT) == [41]
    plc.hears(asks=0)
    assert plc.answers(200.0) == []


def test_the_next_step_of_a_mission_takes_its_own_time(plc: Plc) -> None:
    plc.hears(asks=41)
    assert plc.answers(103.0) == [41]
    plc.hears(asks=42)
    assert plc.answers(105.9) == [] and plc.answers(106.0) == [42]


@pytest.mark.parametrize('fields', [
    {'template': 'other'}, {'template': ''}, {'asks': 0}, {'state': MissionStatus.NEEDS_PERSON}])
def test_it_answers_nothing_that_is_not_for_it(plc: Plc, fields: dict) -> None:
    plc.hears(**{'asks': 41, **fields})
    assert plc.answers(200.0) == []


def test_a_person_who_is_asked_meanwhile_answers(plc: Plc) -> None:
    plc.hears(asks=41)
    plc.hears(asks=41, state=MissionStatus.NEEDS_PERSON)
    assert plc.answers(200.0) == []


def test_it_waits_for_a_fleet_manager_that_restarts(plc: Plc) -> None:
    plc.hears(asks=41)
    plc._commands.is_heard = False
    assert plc.answers(103.0) == []
    plc._commands.is_heard = True
    assert plc.answers(103.2) == [41]
