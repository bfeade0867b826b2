"""`start_output`: runs roslaunch, and shows of its output what a person needs.

    start_output ARGUMENT...      the arguments of roslaunch

roslaunch and the nodes of a fleet print some hundred lines at a start. This shows one line for each
stage, all warnings and errors, and the line that says what is ready; from then on all that nodes
say. After Ctrl-C it shows errors only. It decides only what is shown: ROS keeps all lines in its
log files. It passes SIGINT, SIGTERM and SIGHUP on to roslaunch, and ends with its exit status. If
nothing reads its output any more, it ends roslaunch.

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
from typing import Dict, Optional, Pattern, Sequence, Tuple

PATIENCE = 60.0  # s after which a start that nothing calls ready shows all lines
_ESCAPE = re.compile(r'\x1b\[[0-9;]*[A-Za-z]')
_OF_A_NODE = re.compile(r'\[ *(DEBUG|INFO|WARN|ERROR|FATAL)\] ?\[[^\]]*\]:? ?(?:(/\S+): )?(.*)')
_SUMMARY_NODE = re.compile(r' {4}\S+ \(\S+/\S+\)$')
_MASTER = re.compile(r'ROS_MASTER_URI=(\S+)')
READY = 'Ready: '
#: Lines of a normal start or end that say nothing to a person.
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
    # RViz prints these with some graphics drivers, and draws right
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

    def end(self) -> None:
        """Notes that a person ends the launch."""
        self.state = StartState.ENDING

    def shown(self, line: str, seconds: float) -> str:
        """Returns what a person sees of a line; empty: nothing.

        seconds -- since the start
        """
        if self.state is StartState.STARTING and seconds > PATIENCE:
            self.state = StartState.RUNNING
        line = _ESCAPE.sub('', line).rstrip()
        told = _OF_A_NODE.match(line)
        if told and not any(noise.match(told.group(3)) for noise in _NOISE):
            return self._of_node(line, told.group(1), told.group(3))
        if told or any(noise.match(line) for noise in _NOISE):
            return ''
        return self._of_roslaunch(line)

    def _of_node(self, line: str, severity: str, words: str) -> str:
        if severity in ('ERROR', 'FATAL'):
            return line
        if self.state is StartState.ENDING:
            return ''
        if words.startswith(READY):
            self.state = StartState.RUNNING
            return words
        return line if severity == 'WARN' or self.state is StartState.RUNNING else ''

    def _of_roslaunch(self, line: str) -> str:
        """Returns a line of roslaunch, or what a program prints by itself, such as a traceback."""
        if self.state is not StartState.STARTING:
            return line
        if _SUMMARY_NODE.match(line):
            self._nodes += 1
            return ''
        master = _MASTER.match(line)
        if master:
            return f'{self._nodes} nodes start under the ROS master at {master.group(1)}'
        return line


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns the exit status of roslaunch."""
    output, begun = StartOutput(), time.monotonic()
    environment: Dict[str, str] = {**os.environ, 'PYTHONUNBUFFERED': '1'}  # else lines come late
    # Its group is its own: else a Ctrl-C would reach it twice, here and from the terminal.
    launch = subprocess.Popen(
        ['roslaunch', '--disable-title',
         *(sys.argv[1:] if arguments is None else arguments)],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        errors='replace', start_new_session=True, env=environment)

    def pass_on(number: int, _: Optional[FrameType]) -> None:
        output.end()
        launch.send_signal(number)
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, pass_on)
    assert launch.stdout is not None
    for line in launch.stdout:
        shown = output.shown(line, time.monotonic() - begun)
        if not shown:
            continue
        try:
            print(shown, flush=True)
        except BrokenPipeError:  # the reader has gone, as with `| head`
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            pass_on(signal.SIGINT, None)
    return launch.wait()
