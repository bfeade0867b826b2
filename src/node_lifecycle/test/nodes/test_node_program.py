"""A node's program ends on Ctrl-C from its first line on."""
from __future__ import annotations

import re
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


def program(folder: Path, module: str) -> subprocess.CompletedProcess:
    (folder / 'swallows.py').write_text(module)
    source = SOURCES / 'node_lifecycle' / 'src'
    return subprocess.run(
        [sys.executable, '-c', f'import sys; sys.path[:0] = [{str(folder)!r}, {str(source)!r}];'
         "from node_program import run_main; run_main('swallows')"],
        capture_output=True, text=True, timeout=60.0)


def test_an_interrupt_while_modules_are_imported_ends_the_program_without_a_traceback(tmp_path):
    ended = program(tmp_path, SWALLOWS)
    assert (ended.returncode, ended.stdout, ended.stderr) == (-signal.SIGINT, '', '')


def test_what_main_returns_is_the_exit_status(tmp_path):
    ended = program(tmp_path, SWALLOWS.replace('os.kill(os.getpid(), signal.SIGINT)', 'pass')
                    .replace('time.sleep(5.0)', 'pass'))
    assert (ended.returncode, ended.stdout, ended.stderr) == (3, 'runs on\n', '')


def test_every_node_begins_so():
    """That is, all programs of modules that take ROS's signals themselves."""
    nodes = [text for text in (file.read_text() for file in SOURCES.glob('*/nodes/*'))
             if re.search(r'[\'"]\w+\.nodes\.\w+[\'"]|from \w+\.nodes\.\w+ import main', text)]
    assert len(nodes) >= 15
    assert [text for text in nodes if 'from node_program import run_main' not in text] == []
