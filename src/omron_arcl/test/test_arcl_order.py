"""A robot answers in the order in which commands came; the published fate of a drive is true.

An emergency stop or a cancellation may end a command for its giver while the robot has still to
answer it. The answer to such a command does not count as the answer to a newer command with the
same words. And however many commands there are, the controller never forgets a command that the
robot has still to read.
"""
from __future__ import annotations

from collections import Counter
from typing import Callable, List, Optional

import pytest
from drive_bench import PERSON, ROUTE, Bench
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from omron_arcl import Busy, Execution, Giver
from omron_arcl.records import MotionCause

OTHERS = (MotionCause.OTHER_CLIENT, MotionCause.ROBOT, MotionCause.INTERRUPTED)


class RobotInOrder:
    """A robot that may still have to read some commands. No other client drives it.

    names -- whether the robot names the drive that it breaks off
    refuses -- whether the robot answers a drive that it cannot carry out
    halts -- whether the robot says `Stopping` when it replaces a drive
    """

    def __init__(self, names: bool, refuses: bool, halts: bool) -> None:
        self.bench = Bench()
        self.bench.status('Stopped')
        self._names, self._refuses, self._halts = names, refuses, halts
        self._read = 0  # number of commands that the robot has read
        self._given: List[Execution] = []
        self._pressed = False
        self._obeyed: Optional[Execution] = None  # the drive that the robot carries out

    def give(self, text: str, giver: Giver) -> None:
        try:
            self._given.append(self.bench.give(text, giver=giver))
        except Busy:
            assert text != 'stop'

    def cancel(self, which: int) -> None:
        for execution in self._given[which:which + 1]:
            self.bench.dispatcher.cancel(execution, self.bench.now, execution.giver)
            self.bench.send()

    def read(self) -> None:
        if self._read == len(self.bench.sent):
            return
        text = self.bench.sent[self._read]
        self._read += 1
        if text == 'oneLineStatus':
            self.bench.status('EStop pressed' if self._pressed else
                              self._obeyed.command.text.replace('goto', 'Going to')
                              if self._obeyed else 'Stopped')
        elif text == 'stop':
            self._break_off()
            self._say('Stopping', 'Stopped')
        elif not self._pressed:
            replaces = self._obeyed is not None
            self._break_off()
            self._say(*['Stopping'] if replaces and self._halts else [])
            same = [e for e in self._given if e.sent and e.command.text == text]
            self._obeyed = same[self.bench.sent[:self._read].count(text) - 1]
            self._say(text.replace('goto', 'Going to'))
        elif self._refuses:
            self._say(f'CommandError: {text}', 'CommandErrorDescription: EStop pressed')

    def press(self) -> None:
        if not self._pressed:
            self._pressed, self._obeyed = True, None
            self._say('EStop pressed')

    def release(self) -> None:
        if self._pressed:
            self._pressed = False
            self._say('EStop relieved but motors still disabled', 'Motors enabled')

    def arrive(self) -> None:
        if self._obeyed is not None:
            goal, self._obeyed = self._obeyed.command.goals[0], None
            self._say(f'Arrived at {goal}')

    def settle(self) -> None:
        self.release()
        for _ in range(12):
            self.bench.pass_time(1.5)
            self.bench.give('oneLineStatus')
            while self._read < len(self.bench.sent):
                self.read()

    def check(self) -> None:
        """Checks that the drive of the robot is under way, and that its giver is published."""
        memory = self.bench.memory
        assert not memory.stop_owed
        if self._obeyed is not None:
            assert (self._obeyed.result, memory.giver) == (None, self._obeyed.giver)

    def check_records(self) -> None:
        """Checks the records against the commands that the robot has still to read.

        Each unread drive has a record, and a stop that is sent last is owed. Each drive that is
        GIVEN is under way for its giver.
        """
        records = self.bench.records
        under_way = {records.record_of(execution) for execution in self._given}
        assert all(r in under_way for r in self.bench.memory.records if r.pending)
        unread = self.bench.sent[self._read:]
        drives = [text for text in unread if text.startswith('goto')]
        known = [f'goto {r.goal}' for r in self.bench.memory.records if r.may_move]
        assert not Counter(drives) - Counter(known), f'{drives} are to be read, {known} are known'
        if drives and unread[-1] == 'stop':
            assert self.bench.memory.stop_owed

    def _break_off(self) -> None:
        drive, self._obeyed = self._obeyed, None
        if drive is not None and self._names:
            self._say(f'Interrupted: Going to {drive.command.goals[0]}')

    def _say(self, *said: str) -> None:
        for line in said:
            self.bench.robot(line)
            cause = self.bench.memory.cause
            assert cause not in OTHERS, f'"{line}" began an epoch: there is no other client'


GIVEN = [(text, giver) for text in ('goto 3', 'goto 4') for giver in (ROUTE, PERSON)]
ACTS: List[Callable[[RobotInOrder], None]] = [
    *[lambda robot, given=given: robot.give(*given) for given in 2 * GIVEN],
    *[lambda robot, giver=giver: robot.give('stop', giver) for giver in (ROUTE, PERSON)],
    *[lambda robot, which=which: robot.cancel(which) for which in range(2)],
    *3 * [RobotInOrder.press, RobotInOrder.release], *4 * [RobotInOrder.read], RobotInOrder.arrive]


def live(names: bool, refuses: bool, halts: bool,
         acts: List[Callable[[RobotInOrder], None]]) -> None:
    robot = RobotInOrder(names, refuses, halts)
    for act in acts:
        act(robot)
        robot.check_records()
    robot.settle()
    robot.check()


LIVES = given(st.booleans(), st.booleans(), st.booleans(),
              st.lists(st.sampled_from(ACTS), min_size=6, max_size=14))
test_what_is_told_of_each_drive_is_true = LIVES(live)


def test_so_it_is_if_more_drives_are_given_than_are_kept(monkeypatch) -> None:
    monkeypatch.setattr('omron_arcl.drives.MOST_OPEN', 2)
    monkeypatch.setattr('omron_arcl.drives._KEPT_RECORDS', 2)
    LIVES(live)()


FAULTS = {
    'the answers to come are forgotten': {
        'omron_arcl.drives.Drives._has_to_answer': lambda *_: False},
    'the newest records are kept, also of drives that are open': {
        'omron_arcl.drives._KEPT_RECORDS': 3,
        'omron_arcl.drives._shortened': lambda values, most, needless: values[-most:]}}


@pytest.mark.parametrize('fault', FAULTS)
def test_each_planted_fault_is_found(fault, monkeypatch) -> None:
    for what, planted in FAULTS[fault].items():
        monkeypatch.setattr(what, planted)
    with pytest.raises(AssertionError):
        settings(phases=[Phase.generate], database=None)(LIVES(live))()
