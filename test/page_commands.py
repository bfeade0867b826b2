#!/usr/bin/env python3
"""Finds the shell commands of a page, and runs them as a reader would.

page_commands.py PAGE    in a network namespace of its own, so that each port is free

A comment directly above a block says how to run the block:

- `<!-- goes on -->`: a command that runs until the page ends, or until the next such command
- `<!-- not run: REASON -->`: a command that is not run

Each other command must end with exit status 0.
"""
from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import List, Optional

ROOT = Path(__file__).resolve().parents[1]
HOW_TO = ('from_opentcs', 'from_one_robot')  # how-to pages whose commands need no real robot
PAGES = (ROOT / 'README.md', *sorted((ROOT / 'docs' / 'tutorials').glob('*.md')),
         *(ROOT / 'docs' / 'how-to' / f'{name}.md' for name in HOW_TO))
SHELLS = ('bash', 'sh', 'shell', 'console')
# s for which a command that follows a command that goes on is tried again
START = 180.0
COMMAND = 300.0  # s, time limit for each try of a command
END = 60.0  # s after Ctrl-C within which a command must end
_BLOCK = re.compile(r'(?:^<!-- (?P<note>[^\n]*?) -->\n)?^```(?P<language>\w*)\n(?P<text>.*?)^```$',
                    re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A block of a page, with the text of the comment above the block."""

    language: str
    text: str
    note: str
    line: int

    @property
    def is_shell(self) -> bool:
        return self.language in SHELLS

    @property
    def goes_on(self) -> bool:
        return self.note == 'goes on'

    @property
    def reason(self) -> str:
        """Why the block is not run; empty if it is run."""
        return self.note[len('not run:'):].strip() if self.note.startswith('not run:') else ''


class CommandFailed(Exception):
    """A command of a page did not do what the page says that it does."""


def blocks_of(text: str) -> List[Block]:
    return [Block(found['language'], found['text'], found['note'] or '',
                  text.count('\n', 0, found.start('text')))
            for found in _BLOCK.finditer(text)]


class Reader:
    """A reader of a page: one terminal is for commands that go on, the second for all others."""

    def __init__(self, page: Path, home: Path) -> None:
        self._page = page
        self._environment = {'PATH': '/usr/bin:/bin:/usr/sbin:/sbin', 'HOME': str(home),
                             'LANG': 'C.UTF-8', 'ROS_HOME': str(home / 'ros')}
        self._log = (home / 'goes_on.log').open('w+', encoding='utf-8')
        self._terminal = ''  # commands that each new shell of the second terminal runs first
        self._running: Optional[subprocess.Popen] = None

    def follow(self) -> None:
        """Follows the page from its first line to its last line."""
        may_wait = False
        try:
            for block in blocks_of(self._page.read_text(encoding='utf-8')):
                if not block.is_shell or block.reason:
                    continue
                if block.goes_on:
                    self._end(may_wait)
                    self._start(block)
                else:
                    self._do(block, START if may_wait else 0.0)
                may_wait = block.goes_on
            self._end(may_wait)
        finally:
            if self._running is not None:
                self._running.kill()

    def _start(self, block: Block) -> None:
        self._print(block)
        self._running = subprocess.Popen(
            ['bash', '-c', 'exec ' + block.text.strip()], cwd=ROOT, env=self._environment,
            stdout=self._log, stderr=subprocess.STDOUT, start_new_session=True)

    def _do(self, block: Block, patience: float) -> None:
        self._print(block)
        deadline = time.monotonic() + patience
        script = f'set -e\n{self._terminal}{block.text}'
        while True:
            done = subprocess.run(['bash', '-c', script], cwd=ROOT, env=self._environment,
                                  check=False, timeout=COMMAND, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            if done.returncode == 0:
                break
            self._must_run()
            if time.monotonic() > deadline:
                raise self._failure(f'line {block.line}: exit status {done.returncode}\n'
                                    f'{done.stdout}')
            time.sleep(0.5)
        print(done.stdout[-1500:], flush=True)
        self._terminal += ''.join(f'{line}\n' for line in block.text.splitlines()
                                  if line.startswith(('source ', 'export ')))

    def _end(self, must_come_up: bool) -> None:
        """Presses Ctrl-C in the terminal of the command that goes on, as soon as it runs."""
        running = self._running
        if running is None:
            return
        if must_come_up:
            self._do(Block('bash', '. devel/setup.bash\nrosnode list | grep -v /rosout\n', '', 0),
                     START)
        self._must_run()
        os.killpg(running.pid, signal.SIGINT)
        running.wait(END)
        self._running = None

    def _must_run(self) -> None:
        if self._running is not None and self._running.poll() is not None:
            raise self._failure(f'a command that goes on ended with {self._running.returncode}')

    def _failure(self, words: str) -> CommandFailed:
        self._log.seek(0)
        return CommandFailed(f'{self._page.name}: {words}\nOutput of the command that goes on:\n'
                             f'{self._log.read()[-3000:]}')

    @staticmethod
    def _print(block: Block) -> None:
        print(f'--- line {block.line}\n{block.text.strip()}', flush=True)


def alone(page: Path) -> List[str]:
    """Returns the command that runs this file for a page, in network and process namespaces."""
    mapped = [] if os.geteuid() == 0 else ['--map-root-user']
    return ['unshare', *mapped, '--net', '--pid', '--fork', '--kill-child', '--mount-proc',
            '/usr/bin/python3', str(Path(__file__).resolve()), str(page)]


def main() -> int:
    """Returns 0 if all commands of the page did what the page says."""
    subprocess.run(['ip', 'link', 'set', 'lo', 'up'], check=True)
    with tempfile.TemporaryDirectory() as home:
        try:
            Reader(Path(sys.argv[1]).resolve(), Path(home)).follow()
        except (CommandFailed, subprocess.TimeoutExpired) as error:
            print(error, flush=True)
            return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
