"""The search of test_motion_property.py finds each of these planted faults.

Each fault also has a scene, which calls a few rules of the search and so finds the fault.
test_last_word.py finds one more fault: a bridge that gives its stop only once.
"""
from __future__ import annotations

import os
from contextlib import nullcontext
from dataclasses import replace
from typing import Any, Callable, Dict, Tuple

import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis.stateful import run_state_machine_as_test
from modelled_controller import Delays, ModelledController
from test_motion_property import SimulatedRobots

from omron_arcl import drives
from omron_arcl.activity import ActivityKind
from omron_arcl.command_queue import CommandQueue
from omron_arcl.commands import Command
from omron_arcl.drives import Drives
from omron_arcl.execution import NO_GIVER, Execution, Outcome
from omron_arcl.records import DriveMemory, MotionCause, RecordKind
from omron_ld90.bridge.events import MotionTold, RobotLink
from omron_ld90.bridge.robot_monitor import RobotMonitor
from omron_ld90.bridge.route_follower import RouteFollower
from route_protocol.values import EpochCause

Call = Tuple[Any, ...]  # a rule, and its arguments
SEARCH = settings(max_examples=2500, stateful_step_count=30, deadline=None, database=None,
                  phases=[Phase.generate], print_blob=False, report_multiple_bugs=False,
                  suppress_health_check=list(HealthCheck))

_BEGIN, _ON_LINK, _CONNECT, _JUDGE = (
    Drives._begin_epoch, Drives.linked, ModelledController.connect,
    RobotMonitor._judge_foreign_epoch)
_ENDED, _CHECK, _STOP, _OBEYED, _DRIVE_ON = (
    Drives.ended, Drives.check, RobotMonitor.stop, CommandQueue.begin, RouteFollower._drive_on)


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


def _own_epochs_hide_others(self: Any, known: int, event: MotionTold) -> None:
    if not event.is_ours or event.cause is EpochCause.EMERGENCY_STOP:
        _JUDGE(self, known, event)
    self.foreign_epoch = event.foreign_epoch or event.epoch


def _orders_come_first(self: Any, now: float) -> None:
    self.orders.answer(now)
    _DRIVE_ON(self, now)


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
    'the cancellation of a drive is lost with the next one': (
        Drives, '_stop_if_cancelled', lambda *_: None),
    'a robot that leaves its dock obeys the newest drive': (
        Drives, '_may_be_several', lambda *_: False),
    'an own epoch hides those of others before it': (
        RobotMonitor, '_judge_foreign_epoch', _own_epochs_hide_others),
    'an order that waits is taken before the route ends': (
        RouteFollower, '_drive_on', _orders_come_first),
}


_ADAPTER_DRIVES: Tuple[Call, ...] = (('program_drives', '/adapter', '3', 0.0), ('passes', 1.0))
_PERSON_DRIVES: Tuple[Call, ...] = (('person_drives', '3'), ('passes', 1.0))
_ADAPTER_DRIVES_ON: Tuple[Call, ...] = (('program_drives', '/adapter', '4', 0.0), ('passes', 1.0))
_STOP_IN_AN_OUTAGE: Tuple[Call, ...] = (
    *_PERSON_DRIVES, ('link_breaks', RobotLink.COMMANDS, 1.0), ('person_stops',), ('passes', 4.0))
SCENES: Dict[str, Tuple[Call, ...]] = {
    'anybody may drive': (('person_stops',), *_ADAPTER_DRIVES_ON),
    'a stop without a link is forgotten': _STOP_IN_AN_OUTAGE,
    'an owed stop is never sent': _STOP_IN_AN_OUTAGE,
    'a lost stop counts as obeyed': (*_PERSON_DRIVES, ('stop_of_a_person_is_lost', 0.1)),
    'a stop ends newer drives': (*_ADAPTER_DRIVES, ('program_stops', '/joystick', 0.0)),
    'a stop of the bridge ends each motion': (
        ('person_drives_as_a_route_fails', '3', RobotLink.OUTGOING), ('passes', 4.0)),
    'a new link forgets the owed stop': _STOP_IN_AN_OUTAGE,
    'a restart forgets the owed stop': (
        *_PERSON_DRIVES, ('person_stops',), ('controller_restarts', 0.0)),
    'a cancellation is not a word': (('person_cancels',), *_ADAPTER_DRIVES_ON),
    'a restarted giver is the same': (
        *_ADAPTER_DRIVES, ('program_restarts', '/adapter'), *_ADAPTER_DRIVES_ON),
    'an emergency stop begins no epoch': (
        *_ADAPTER_DRIVES, ('reads', '/adapter'), ('emergency_stop',), ('passes', 1.0), ('help',),
        ('passes', 4.0), *_ADAPTER_DRIVES_ON),
    'a stop begins no epoch': (('person_stops',), *_ADAPTER_DRIVES_ON),
    'another client begins no epoch': (
        ('another_client', 'goto 3'), ('passes', 1.0), *_ADAPTER_DRIVES_ON),
    'a drive that the robot broke off begins no epoch': (
        ('program_drives_before_the_robot_has_said_why_it_broke_off', '/adapter', '4', 'stop'),),
    'a drive succeeds as soon as the robot sets out': _ADAPTER_DRIVES,
    'who gave the newest command is the giver': (*_ADAPTER_DRIVES, ('person_drives', '4')),
    'an outage begins no epoch': (
        *_ADAPTER_DRIVES, ('reads', '/adapter'), ('link_breaks', RobotLink.COMMANDS, 1.0),
        ('another_client', 'stop'), ('passes', 4.0), *_ADAPTER_DRIVES_ON),
    'a motion without a name is ours': (
        *_ADAPTER_DRIVES, ('link_breaks', RobotLink.COMMANDS, 1.0),
        ('another_client_drives_without_a_goal', 'gotoPoint 9000 3000 0'), ('passes', 10.0)),
    'a drive is sent again over a new link': (
        *_PERSON_DRIVES, ('link_breaks', RobotLink.COMMANDS, 1.0), ('passes', 4.0)),
    'the cancellation of a drive is lost with the next one': (
        ('program_drives', '/adapter', '5', 0.0), ('passes', 1.0), ('link_stalls', 3.0),
        ('person_drives', '3'), ('giver_cancels_its_drive', 0),
        ('link_breaks', RobotLink.COMMANDS, 1.0), ('passes', 8.0)),
    'a robot that leaves its dock obeys the newest drive': (
        ('robot_leaves_its_dock_for_a_cancelled_drive', 0.3), ('passes', 4.0)),
    'an own epoch hides those of others before it': (
        ('epoch_of_others_is_replaced_by_one_of_the_bridge', ('person_stops',)),),
    'an order that waits is taken before the route ends': (
        ('order_comes_before_the_robot_has_said_why_it_broke_off', 0, 'stop'),),
}
assert set(SCENES) == set(FAULTS)


@pytest.mark.parametrize('is_planted', [False, True])
@pytest.mark.parametrize('fault', SCENES)
def test_it_is_found_in_a_scene(fault, is_planted, monkeypatch):
    if is_planted:
        monkeypatch.setattr(*FAULTS[fault])
    robots = SimulatedRobots()
    robots.begin('rolling', 'interrupted name', Delays(commands=1.0, to_robot=0.2))
    for rule, *arguments in SCENES[fault]:
        getattr(robots, rule)(*arguments)
    robots.settle()
    with pytest.raises(AssertionError) if is_planted else nullcontext():
        robots.no_drive_is_sent_twice()
        robots.check_end()


@pytest.mark.skipif(os.environ.get('LD90_LONG_TESTS') != '1',
                    reason='takes minutes; LD90_LONG_TESTS=1')
@pytest.mark.parametrize('fault', FAULTS)
def test_it_is_found(fault, monkeypatch):
    monkeypatch.setattr(*FAULTS[fault])
    with pytest.raises(AssertionError):
        run_state_machine_as_test(SimulatedRobots, settings=SEARCH)
