"""`start_output`: runs roslaunch, and shows the part of its output that a person needs.

    start_output ARGUMENT...      the arguments of roslaunch

roslaunch and the nodes of a fleet print some hundred lines at a start. This program shows one line
for each stage, all warnings and errors, and the line that says what is ready. After that line it
shows everything that nodes print. After Ctrl-C it shows errors only. It decides only what is shown:
ROS keeps all lines in its log files. It passes SIGINT, SIGTERM and SIGHUP on to roslaunch, even if
they come before roslaunch runs. It exits with the status of roslaunch. If its own output is
closed, it ends roslaunch.

It recognises the kind of a line by the fields of its form (`screen_lines`), never by its words. The
user can set another form in ROSCONSOLE_FORMAT; lines in that form are all shown.

States:  STARTING  until a node says that it is ready, or PATIENCE is over
         RUNNING   until a signal comes
         ENDING
"""
from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from enum import Enum
from types import FrameType
from typing import Dict, List, Optional, Pattern, Sequence, Tuple

from node_program.screen_lines import FORM, READY

PATIENCE = 60.0  # s; all later lines are shown if no line has said by then what is ready
LATE = (f'For {PATIENCE:.0f} s no node has said that all is ready: from here on all lines are '
        'shown.')
_ESCAPE = re.compile(r'\x1b\[[0-9;]*[A-Za-z]')
_OF_A_NODE = re.compile(  # in the FORM of screen_lines
    r'\[ *(?P<severity>DEBUG|INFO|WARN|ERROR|FATAL)\] (?P<stamp>\[[^\]]*\]) '
    r'\[(?:[^\]]*\.)?(?P<logger>[^\].]*)\] (?P<node>\S*): (?P<words>.*)')
_TRACEBACK = 'Traceback (most recent call last):'
_SUMMARY_NODE = re.compile(r' {4}\S+ \(\S+/\S+\)$')
_MASTER = re.compile(r'ROS_MASTER_URI=(\S+)')
#: Lines of a normal start or end that mean nothing to a person.
_NOISE: Tuple[Pattern[str], ...] = tuple(map(re.compile, (
    r'\.\.\. logging to ', r'Checking log directory', r'Press Ctrl-C to interrupt$',
    r'Done checking log file', r'started roslaunch server ', r'SUMMARY$', r'=+$',
    r'(CLEAR )?PARAMETERS$', r' \* /', r'NODES$', r'  /\S*$', r'auto-starting new master$',
    r'master has started, initiating launch$', r'setting /run_id to ', r'started core service ',
    r'process\[\S+\]: started with pid ', r'INFO: cannot create a symlink', r'$',
    r'\[\S+\] killing on exit', r'shutting down processing monitor',
    r'\.\.\. shutting down processing monitor complete$', r'done$',
    r'(faults|ready: ARCL) on ',  # of a simulator
    r'\d+: Note: It is recommended to replace `message_size_limit`',  # of some mosquittos
    # RViz prints these lines with some graphics drivers, but draws correctly
    r'QStandardPaths: ', r'\[(rospack|librospack)\].*(media_export|executing command)',
    r'rviz/glsl120/', r' GLSL link result', r'active samplers with a different type')))


class StartState(Enum):
    """A state of the start; see the docstring of the module."""

    STARTING = 'starting'
    RUNNING = 'running'
    ENDING = 'ending'


class StartOutput:
    """Decides which lines are shown, and how."""

    def __init__(self) -> None:
        self.state = StartState.STARTING
        self._nodes = 0
        self._traceback: List[str] = []  # the lines so far of a traceback after Ctrl-C

    def end(self) -> None:
        """Notes that a person has ended the launch."""
        self.state = StartState.ENDING

    def shown(self, line: str, seconds: float) -> str:
        """Returns the text to show for a line; empty: nothing is shown.

        seconds -- time since the start
        """
        if self.state is StartState.STARTING and seconds > PATIENCE:
            self.state = StartState.RUNNING
            return '\n'.join(filter(None, (LATE, self.shown(line, seconds))))
        line = _ESCAPE.sub('', line).rstrip()
        told = _OF_A_NODE.match(line)
        if any(noise.match(told.group('words') if told else line) for noise in _NOISE):
            return ''
        return self._of_node(**told.groupdict()) if told else self._of_roslaunch(line)

    def _of_node(self, severity: str, stamp: str, logger: str, node: str, words: str) -> str:
        line = f'[{severity}] {stamp} {node}: {words}'
        if severity in ('ERROR', 'FATAL'):
            return line
        if self.state is StartState.ENDING:
            return ''
        if logger == READY:
            self.state = StartState.RUNNING
            return words
        return line if severity == 'WARN' or self.state is StartState.RUNNING else ''

    def _of_roslaunch(self, line: str) -> str:
        """Returns the text to show for a line of roslaunch, or of a program that is no node."""
        if self.state is StartState.ENDING:
            return self._of_the_end(line)
        if self.state is StartState.RUNNING:
            return line
        if _SUMMARY_NODE.match(line):
            self._nodes += 1
            return ''
        master = _MASTER.match(line)
        if master:
            return f'{self._nodes} nodes start under the ROS master at {master.group(1)}'
        return line

    def _of_the_end(self, line: str) -> str:
        """Returns the text to show for a line after Ctrl-C, without the tracebacks of Ctrl-C."""
        if not self._traceback and line != _TRACEBACK:
            return line
        self._traceback.append(line)
        if line.startswith(' ') or len(self._traceback) == 1:
            return ''
        told, self._traceback = self._traceback, []
        return '' if line == KeyboardInterrupt.__name__ else '\n'.join(told)


class PassedSignals:
    """Passes signals on to a program as soon as the program runs."""

    def __init__(self, output: StartOutput) -> None:
        self._output = output
        self._early: List[int] = []
        self._launch: Optional[subprocess.Popen[str]] = None

    def receive(self, number: int, _: Optional[FrameType] = None) -> None:
        """Passes a signal on. This is the handler of signals."""
        self._output.end()
        if self._launch is None:
            self._early.append(number)
        else:
            self._launch.send_signal(number)

    def begin(self, launch: subprocess.Popen[str]) -> None:
        """Passes all further signals on to `launch`, which runs now; sends earlier ones at once."""
        self._launch = launch
        for number in self._early:
            launch.send_signal(number)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns the exit status of roslaunch."""
    output, begun = StartOutput(), time.monotonic()
    environment: Dict[str, str] = {
        'ROSCONSOLE_FORMAT': FORM, **os.environ, 'PYTHONUNBUFFERED': '1'}  # so lines come at once
    signals = PassedSignals(output)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signals.receive)
    # It has its own process group. Otherwise it would get Ctrl-C twice: from the terminal and from
    # here.
    launch = subprocess.Popen(
        ['roslaunch', '--disable-title',
         *(sys.argv[1:] if arguments is None else arguments)],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        errors='replace', start_new_session=True, env=environment)
    signals.begin(launch)
    assert launch.stdout is not None
    for line in launch.stdout:
        shown = output.shown(line, time.monotonic() - begun)
        if not shown:
            continue
        try:
            print(shown, flush=True)
        except BrokenPipeError:  # the reader has ended, as with `| head`
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            signals.receive(signal.SIGINT)
    return launch.wait()
