"""Ctrl-C ends the program of a node or of a command, even while its first line runs."""
from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

SOURCES = Path(__file__).resolve().parents[4] / 'src'
SWALLOWS = '''
import os, signal, time
try:
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(5.0)
except:  # as libraries do that try what there is
    pass

def main():
    print('runs on')
    return 3
'''


WORKS = '''
import os, signal, time

def main():
    try:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(5.0)
    except KeyboardInterrupt:
        print('tidies up')
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(5.0)
'''


def program(folder: Path, module: str, run: str = 'run_main') -> subprocess.CompletedProcess:
    (folder / 'swallows.py').write_text(module)
    source = SOURCES / 'node_lifecycle' / 'src'
    return subprocess.run(
        [sys.executable, '-c', f'import sys; sys.path[:0] = [{str(folder)!r}, {str(source)!r}];'
         f"from node_program import {run}; {run}('swallows')"],
        capture_output=True, text=True, timeout=60.0)


def test_an_interrupt_while_modules_are_imported_ends_the_program_without_a_traceback(tmp_path):
    ended = program(tmp_path, SWALLOWS)
    assert (ended.returncode, ended.stdout, ended.stderr) == (-signal.SIGINT, '', '')


def test_what_main_returns_is_the_exit_status(tmp_path):
    ended = program(tmp_path, SWALLOWS.replace('os.kill(os.getpid(), signal.SIGINT)', 'pass')
                    .replace('time.sleep(5.0)', 'pass'))
    assert (ended.returncode, ended.stdout, ended.stderr) == (3, 'runs on\n', '')


def test_an_interrupt_ends_a_command_silently_with_status_130(tmp_path):
    for module in (SWALLOWS, WORKS, WORKS.replace("print('tidies up')", 'raise')):
        ended = program(tmp_path, module, 'run_command')
        assert (ended.returncode, ended.stderr) == (130, ''), module
        assert ended.stdout == ('tidies up\n' if 'tidies' in module else '')


def test_what_a_command_returns_is_the_exit_status(tmp_path):
    ended = program(tmp_path, 'def main():\n    return 2\n', 'run_command')
    assert (ended.returncode, ended.stdout, ended.stderr) == (2, '', '')
