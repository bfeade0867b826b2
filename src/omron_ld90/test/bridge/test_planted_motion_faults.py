"""The search of test_motion_property.py finds each of these planted faults.

test_last_word.py finds a bridge that gives its stop only once.
"""
from __future__ import annotations

import os
from dataclasses import replace
from typing import Any, Callable

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.stateful import run_state_machine_as_test
from modelled_controller import ModelledController
from test_motion_property import SimulatedRobots

from omron_arcl import drives
from omron_arcl.activity import ActivityKind
from omron_arcl.command_queue import CommandQueue
from omron_arcl.commands import Command
from omron_arcl.drives import Drives
from omron_arcl.execution import NO_GIVER, Execution, Outcome
from omron_arcl.records import DriveMemory, MotionCause, RecordKind
from omron_ld90.bridge.robot_monitor import RobotMonitor

pytestmark = pytest.mark.skipif(os.environ.get('LD90_LONG_TESTS') != '1',
                                reason='takes minutes; LD90_LONG_TESTS=1')
SEARCH = settings(max_examples=2500, stateful_step_count=30, deadline=None, database=None,
                  phases=[Phase.generate], print_blob=False, report_multiple_bugs=False,
                  suppress_health_check=list(HealthCheck))

_BEGIN, _ON_LINK, _CONNECT = (
    Drives._begin_epoch, Drives.linked, ModelledController.connect)
_ENDED, _CHECK, _STOP, _OBEYED = (
    Drives.ended, Drives.check, RobotMonitor.stop, CommandQueue.begin)


def _no_epoch_for(cause: MotionCause) -> Callable[..., None]:
    def begin(self: Any, giver: Any, why: MotionCause, reason: str, drives: bool,
              given: Any = None) -> None:
        if why is cause:
            self._memory = replace(self._memory, cause=why)
            self._keep(given)
        else:
            _BEGIN(self, giver, why, reason, drives, given)
    return begin


def _interrupted_is_ignored(self: Any, giver: Any, why: MotionCause, reason: str, drives: bool,
                            given: Any = None) -> None:
    if why is MotionCause.INTERRUPTED:
        self._keep(given)
    else:
        _BEGIN(self, giver, why, reason, drives, given)


def _link_forgets(self: Any, connected: bool, now: float) -> None:
    _ON_LINK(self, connected, now)
    self._records = tuple(r for r in self._records if r.kind is not RecordKind.STOP)
    self._keep()


def _names_alone(self: Any, giver: Any, epoch: int) -> Any:
    return epoch == self._memory.epoch or self._memory.giver.name == giver.name


def _sends_again(self: Any) -> None:
    drives = [r for r in self._dispatcher.records._records if r.kind is RecordKind.DRIVE]
    _CONNECT(self)
    if drives:
        self._send_line(f'goto {drives[-1].goal}')


def _lost_is_obeyed(self: Any, execution: Any, outcome: Outcome, words: str, now: float) -> None:
    is_stop = execution.command.spec.stops
    _ENDED(self, execution, Outcome.SUCCEEDED if is_stop else outcome, words, now)


def _drives_alone(self: Any, giver: Any, command: Command, known_epoch: int,
                  number: int = 0) -> None:
    if command.spec.drives:
        _CHECK(self, giver, command, known_epoch, number)


def _begun_is_done(self: Any, execution: Execution, line: str) -> None:
    is_new = not self.records.has_begun(execution)
    _OBEYED(self, execution, line)
    if is_new:
        self.end(execution, Outcome.SUCCEEDED, '')


def _whatever_is_shown_is_ours(self: Any, activity: Any, text: str) -> None:
    self._unseen = False


_GIVER_OF_THE_NEWEST = property(
    lambda memory: memory.records[-1].giver if memory.records else NO_GIVER)


FAULTS = {
    'anybody may drive': (Drives, 'check', lambda *_: None),
    'a stop without a link is forgotten': (
        Drives, 'stopped_without_link', lambda *_: None),
    'an owed stop is never sent': (Drives, 'stop_due', lambda *_: False),
    'a lost stop counts as obeyed': (Drives, 'ended', _lost_is_obeyed),
    'a stop ends newer drives': (Drives, 'check', _drives_alone),
    'a stop of the bridge ends each motion': (
        RobotMonitor, 'stop', lambda self, epoch: _STOP(self, 0)),
    'a new link forgets the owed stop': (Drives, 'linked', _link_forgets),
    'a restart forgets the owed stop': (ModelledController, '_keep', lambda *_: None),
    'a cancellation is not a word': (Drives, 'all_cancelled', lambda *_: None),
    'a restarted giver is the same': (Drives, 'knows', _names_alone),
    'an emergency stop begins no epoch': (
        Drives, '_begin_epoch', _no_epoch_for(MotionCause.EMERGENCY_STOP)),
    'a stop begins no epoch': (Drives, '_begin_epoch', _no_epoch_for(MotionCause.STOP)),
    'another client begins no epoch': (
        Drives, '_begin_epoch', _no_epoch_for(MotionCause.OTHER_CLIENT)),
    'a drive that the robot broke off begins no epoch': (
        Drives, '_begin_epoch', _interrupted_is_ignored),
    'a drive succeeds as soon as the robot sets out': (CommandQueue, 'begin', _begun_is_done),
    'who gave the newest command is the giver': (DriveMemory, 'giver', _GIVER_OF_THE_NEWEST),
    'an outage begins no epoch': (Drives, '_first_shown', _whatever_is_shown_is_ours),
    'a motion without a name is ours': (
        drives, '_may_cause', lambda drive, activity: drive.may_move and (
            activity.kind is not ActivityKind.GOING_TO_GOAL
            or activity.goal.casefold() in drive.names)),
    'a drive is sent again over a new link': (ModelledController, 'connect', _sends_again),
}


@pytest.mark.parametrize('fault', FAULTS)
def test_it_is_found(fault, monkeypatch):
    monkeypatch.setattr(*FAULTS[fault])
    with pytest.raises(AssertionError):
        run_state_machine_as_test(SimulatedRobots, settings=SEARCH)
