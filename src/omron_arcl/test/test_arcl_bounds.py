"""A robot may send anything, in any order and in any pieces; commands are cancelled, links break.

In each case, each command ends within its time limit and has one outcome. No motion is sent
twice, and a stop is sent before all other commands. 60 histories by default, 10,000 with
LD90_LONG_TESTS=1.
"""
from __future__ import annotations

import os
from collections import Counter
from typing import Dict, List, Optional

from arcl_builders import lines
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from omron_arcl import COMMANDS, Execution, Result, parse_command
from omron_arcl.dispatcher import Dispatcher
from omron_arcl.parser import _TABLE
from omron_arcl.session import Received, Session

EXAMPLES = 10_000 if os.environ.get('LD90_LONG_TESTS') == '1' else settings.default.max_examples
NAMES = sorted(COMMANDS)
DRIVES = sorted(name for name, spec in COMMANDS.items() if spec.drives)
# s, longest time of one command; a command may wait for several others with the same name.
LONGEST_WAIT = 61.0
LATER = 100  # steps after the end of the last command; nothing may be sent in them

STATUS = 'Status: {} StateOfCharge: 79.4 Location: 1 2 3 Temperature: 36'
ACTIVITIES = (
    'Going to 1', 'Arrived at 1', 'Going to point', 'Arrived at point', 'Going to 7', 'Stopping',
    'Arrived at 7', 'Going to 1 1', 'Arrived at 1 1', 'Failed going to 1', 'Stopped', 'Parked',
    'Interrupted: Going to 1', 'Interrupted: Going to -5 -6', 'Error: Failed going to goal',
    'Cannot find path', 'EStop pressed', 'Motors disabled', 'Motors enabled', 'Robot lost',
    'Patrolling route 1', 'Doing task 1', 'Completed doing task 1', 'Executing macro 1',
    *(f'DockingState: {state} ForcedState: Unforced ChargeState: Not'
      for state in ('Docked', 'Undocking', 'Undocked', 'Docking')))
SAID = [line.encode() for line in (
    *ACTIVITIES, *(STATUS.format(activity) for activity in ACTIVITIES), STATUS.format('Waiting'),
    'CommandError: goto 1', "CommandErrorDescription: No goal '1'", 'CommandError: stop',
    'Unknown command stop', 'SetUpError: no', "No goal '1'", 'Goal: 1', 'End of goals',
    *(f'{head} 1' for head, _ in _TABLE))] + [b'caf\xe9', b'\xff\xfe\x00', b'']
# Lines that a robot may send for ever without confirming any command.
NOISE = [line.encode() for line in (
    'Stopping', 'Stopped', 'Interrupted: Going to -5 -6', 'hello', 'Goal: 1', 'Temperature: 36',
    'EStop relieved but motors still disabled', 'Motors enabled', 'Charge requested',
    'DockingState: Docked ForcedState: Unforced ChargeState: Not',
    *(STATUS.format(text) for text in ('Stopped', 'Waiting', 'Arrived at 7', 'Parked',
                                       'Interrupted: x', 'Driving', '')))] + [b'\xff\xfe', b'']


class History:
    """A robot and its commands, driven by a script of bytes; two bytes per step."""

    def __init__(self) -> None:
        self.now = 100.0
        self.given: List[Execution] = []
        self.ends: Dict[int, List[float]] = {}
        self._dispatcher = Dispatcher()
        self._session = Session(None)
        self._sent: Counter = Counter()
        self._cancels = 0
        self._pending = b''

    def play(self, script: bytes) -> None:
        for what, which in zip(script[::2], script[1::2]):
            if what < 30:
                self.give('stop')
            elif what < 90:
                self.give(DRIVES[which % len(DRIVES)])
            elif what < 110:
                self.give(NAMES[which % len(NAMES)])
            elif what < 130 and self.given:
                self._cancels += 1
                self._dispatcher.cancel(self.given[which % len(self.given)], self.now)
            elif what < 150:
                self.wait(which / 20.0)
            elif what < 153:
                self.lose()
            else:
                self.say(SAID[which % len(SAID)], cut=what)
            if what % 3:
                self.send()

    def give(self, name: str) -> None:
        text = ' '.join([name, *['1'] * COMMANDS[name].required])
        number = len(self.given)
        self.ends[number] = []

        def on_end(_: Result) -> None:
            self.ends[number].append(self.now)
        self.given.append(self._dispatcher.start(parse_command(text), on_end=on_end))

    def say(self, line: bytes, cut: int = 0) -> None:
        """Sends a line of the robot; its last bytes may arrive only with the next line."""
        self._pending += lines(line)
        size = len(self._pending) - cut % 7
        piece, self._pending = self._pending[:size], self._pending[size:]
        for event in self._session.receive(piece):
            assert isinstance(event, Received)
            self._dispatcher.on_reply(event.reply, event.text, self.now)
        self.tell()

    def lose(self) -> None:
        """Breaks the link. Data on its way is lost: it does not arrive on the next link."""
        self._dispatcher.on_lost('lost')
        self._session, self._pending = Session(None), b''
        self.tell()
        assert all(execution.result for execution in self.given)

    def wait(self, seconds: float) -> None:
        self.now += seconds
        self._dispatcher.on_time(self.now)
        self.tell()

    def send(self) -> None:
        stop_waits = any(e.command.spec.stops and not e.sent and e.result is None
                         for e in self.given)
        first: Optional[bytes] = None
        while True:
            line = self._dispatcher.next_to_send(self.now)
            if line is None:
                break
            first = first or line
            self._sent[line] += 1
        assert not stop_waits or first == b'stop', f'{first!r} was sent before the stop'

    def tell(self) -> None:
        for callback in self._dispatcher.pop_callbacks():
            callback()

    def check_sent(self) -> None:
        once = Counter(execution.command.line for execution in self.given if execution.sent)
        stops, sent = self._sent.pop(b'stop', 0), dict(self._sent)
        assert stops <= once.pop(b'stop', 0) + self._cancels, f'{stops} stops were sent'
        assert sent == once, 'not every command was sent exactly once'


@settings(max_examples=EXAMPLES, database=None, suppress_health_check=list(HealthCheck))
@given(st.binary(min_size=80, max_size=80), st.sampled_from([None, *NOISE]))
def test_every_command_ends_once_and_within_its_bound(script, noise):
    history = History()
    history.play(script)
    history.send()
    quiet, ended = history.now, 0
    for seconds in (*[1.0] * 100, *[30.0] * (len(history.given) * 3 + 125)):
        history.wait(seconds)
        if noise is not None:
            history.say(noise)
        history.send()
        ended = 0 if any(one.result is None for one in history.given) else ended + 1
        if ended == LATER:
            break
    for number, execution in enumerate(history.given):
        ends, spec = history.ends[number], execution.command.spec
        assert len(ends) == 1, f'"{execution.command.text}" has {len(ends)} outcomes'
        bound = (max(spec.timeout, 300.0) + 60.0 if spec.drives
                 else LONGEST_WAIT * len(history.given))
        assert ends[0] - quiet <= bound, f'"{execution.command.text}" took {ends[0] - quiet:.0f} s'
    history.check_sent()
