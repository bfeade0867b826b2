"""A person sees one line for each stage of a start, all warnings, and the line about what is ready.
"""
from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Iterator, List, Tuple

import pytest

from fleet_bringup.start_output import LATE, PATIENCE, PassedSignals, StartOutput, StartState
from node_program.screen_lines import FORM

START = """... logging to /home/anna/.ros/log/0ad8b654/roslaunch-vm-19581.log
Checking log directory for disk usage. This may take a while.
Press Ctrl-C to interrupt
Done checking log file disk usage. Usage is <1GB.

\x1b[1mstarted roslaunch server http://127.0.0.1:39275/\x1b[0m

SUMMARY
========

CLEAR PARAMETERS
 * /ld90_1/

PARAMETERS
 * /ld90_1/omron_controller/base_map:\x20

NODES
  /
    ld90_sim (omron_ld90_sim/ld90_sim)
    path_supervisor (graph_fleet_manager/path_supervisor)
  /ld90_1/
    omron_controller (omron_ld90/omron_controller)

auto-starting new master
\x1b[1mprocess[master]: started with pid [24689]\x1b[0m
\x1b[1mROS_MASTER_URI=http://127.0.0.1:11311/\x1b[0m
\x1b[1msetting /run_id to 7aa66a60\x1b[0m
started core service [/rosout]
\x1b[1mprocess[ld90_1/omron_controller-5]: started with pid [24783]\x1b[0m
[rospack] Error: no such package media_export
[librospack]: error while executing command
ready: ARCL on 127.0.0.1:24500 (ld90_1)
[INFO] [1795766631.227239] [rosout] /ld90_1/omron_controller: Link to 127.0.0.1:24350 is up.
\x1b[31m[ERROR] [1795766632.159213074] [ros.rviz] /rviz: rviz/glsl120/indexed_8bit_image.vert
rviz/glsl120/indexed_8bit_image.frag
 GLSL link result :\x20
active samplers with a different type refer to the same texture image unit\x1b[0m
""".splitlines()


Told = Tuple[str, str, str]
"""Severity, node and words of a line."""


def line_of(severity: str, node: str, words: str, logger: str = 'rosout') -> str:
    """Returns a line as rospy prints it."""
    values = {'severity': severity, 'time': '1795766641.3', 'node': node, 'message': words,
              'logger': logger}
    return re.sub(r'\$\{(\w+)\}', lambda name: values[name.group(1)], FORM)


def seen_of(severity: str, node: str, words: str) -> str:
    """Returns the same line as `start_output` shows it."""
    return f'[{severity}] [1795766641.3] {node}: {words}'


IS_READY = '8 robots are ready. Open http://localhost:8080.'
READY = line_of('INFO', '/fleet_page', IS_READY, 'rosout.ready')
NEWS, WARNING, ERROR = (
    ('INFO', '/path_supervisor', 'anna requests mission 4 to 18.'),
    ('WARN', '/ld90_1/omron_controller', 'Link "commands" is down: refused.'),
    ('ERROR', '/ld90_1/omron_controller', 'Link "commands" is down: refused.'))
END = ['[ld90_sim-2] killing on exit', 'shutting down processing monitor...',
       '... shutting down processing monitor complete', '\x1b[1mdone\x1b[0m']


def seen(output: StartOutput, *lines: str, seconds: float = 1.0) -> List[str]:
    return [shown for shown in (output.shown(f'{line}\n', seconds) for line in lines) if shown]


def test_a_normal_start_is_one_line_and_the_line_that_says_what_is_ready() -> None:
    assert seen(StartOutput(), *START, READY) == [
        '3 nodes start under the ROS master at http://127.0.0.1:11311/', IS_READY]


@pytest.mark.parametrize('told', [WARNING, ERROR])
def test_warnings_and_errors_of_nodes_are_seen_at_once(told: Told) -> None:
    assert seen(StartOutput(), *START, line_of(*told))[1:] == [seen_of(*told)]


@pytest.mark.parametrize('line', [
    'Traceback (most recent call last):',
    '  File "/a.py", line 3, in <module>', "ValueError: no map",
    'RLException: [x.launch] requires the \'map\' arg to be set',
    '[ld90_sim-2] process has died [pid 9, exit code 1, cmd /a __name:=ld90_sim].'])
def test_trouble_is_seen_at_once(line: str) -> None:
    assert seen(StartOutput(), *START, line)[1:] == [line]


def test_what_nodes_say_is_seen_when_the_fleet_is_ready() -> None:
    output = StartOutput()
    assert seen(output, line_of(*NEWS)) == []
    assert seen(output, READY, line_of(*NEWS)) == [IS_READY, seen_of(*NEWS)]


def test_the_words_of_a_line_never_make_the_fleet_ready() -> None:
    output = StartOutput()
    assert seen(output, line_of('INFO', '/fleet_page', 'Ready: 8 robots.'),
                line_of('INFO', '/fleet_page', '[rosout.ready] /x: Ready: 8 robots.'),
                line_of(*NEWS)) == []
    assert output.state is StartState.STARTING


def test_lines_in_a_form_of_the_user_are_all_seen() -> None:
    lines = ['INFO: anna requests mission 4 to 18.', 'WARN: the link is down']
    assert seen(StartOutput(), *lines) == lines


def test_a_start_that_nothing_calls_ready_says_so_and_shows_all_after_a_while() -> None:
    output = StartOutput()
    assert seen(output, line_of(*NEWS), seconds=PATIENCE) == []
    assert seen(output, line_of(*NEWS), line_of(*NEWS), seconds=PATIENCE + 1.0) == [
        f'{LATE}\n{seen_of(*NEWS)}', seen_of(*NEWS)]


def test_after_ctrl_c_only_errors_are_seen() -> None:
    output = StartOutput()
    seen(output, READY)
    output.end()
    assert seen(output, line_of(*WARNING), line_of(*NEWS), *END, line_of(*ERROR)) == [
        seen_of(*ERROR)]


def test_after_ctrl_c_the_traceback_of_what_it_ended_is_not_seen_but_that_of_a_defect_is() -> None:
    output, begin = StartOutput(), ['Traceback (most recent call last):', '  File "/a.py", line 3']
    output.end()
    assert seen(output, *begin, 'KeyboardInterrupt') == []
    assert seen(output, *begin, 'KeyError: 3', 'other') == [
        '\n'.join([*begin, 'KeyError: 3']), 'other']


def test_a_signal_before_roslaunch_runs_reaches_it_when_it_runs() -> None:
    output = StartOutput()
    signals = PassedSignals(output)
    signals.receive(signal.SIGTERM)
    assert output.state is StartState.ENDING
    with subprocess.Popen(['sleep', '60']) as launch:
        signals.begin(launch)
        assert launch.wait(10) == -signal.SIGTERM


@pytest.fixture
def shown(tmp_path: Path) -> Iterator[subprocess.Popen]:
    """Yields `start_output` with a stand-in for roslaunch that prints which signal it got."""
    program = tmp_path / 'roslaunch'
    program.write_text(f"""#!{sys.executable}
import signal, sys
def end(sign, _):
    print('ERROR: got', sign)
    sys.exit(40 + sign)
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    signal.signal(number, end)
print('works with', sys.argv[1:])
while True:
    signal.sigtimedwait([], 0.1)
    print('more')
""")
    program.chmod(0o755)
    with subprocess.Popen(
            [sys.executable, '-c', 'import sys; from fleet_bringup.start_output import main; '
             'sys.exit(main(["a.launch"]))'], stdout=subprocess.PIPE, text=True,
            env={**os.environ, 'PATH': f'{tmp_path}:{os.environ["PATH"]}'}) as process:
        yield process
        process.kill()


@pytest.mark.parametrize('sign', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_reaches_roslaunch_whose_exit_status_is_returned(
        shown: subprocess.Popen, sign: signal.Signals) -> None:
    assert shown.stdout is not None
    assert shown.stdout.readline() == "works with ['--disable-title', 'a.launch']\n"
    shown.send_signal(sign)
    assert shown.stdout.read().endswith(f'ERROR: got {int(sign)}\n')
    assert shown.wait(10) == 40 + sign


def test_roslaunch_ends_if_nothing_reads_the_output_any_more(shown: subprocess.Popen) -> None:
    assert shown.stdout is not None
    shown.stdout.readline()
    shown.stdout.close()
    assert shown.wait(10) == 40 + signal.SIGINT
