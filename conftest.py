"""Settings for all unit tests: examples of hypothesis, proofs, and a small disk.

No example has a deadline, because a loaded machine is no defect. By default each run tries the same
examples, so that a result depends only on the change. With LD90_LONG_TESTS=1 (scripts/test.sh
--long) each run tries more examples, and new ones. HYPOTHESIS_PROFILE=compatibility is for a second
Python version, under which the tests only look for code that does not work there at all. This
profile tries the smallest number of examples with which every property still finds an example.
"""
from __future__ import annotations

import ast
import contextlib
import ctypes
import functools
import gc
import os
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from socketserver import BaseServer
from types import FrameType
from typing import Any, Callable, Iterator, List, Optional, TypeVar

import pytest
from hypothesis import HealthCheck, settings

sys.path.append(str(Path(__file__).parent / 'test'))
pytest_plugins = ['proofs', 'second_python']
LONG = os.environ.get('LD90_LONG_TESTS') == '1'

settings.register_profile('project', deadline=None, max_examples=500 if LONG else 60,
                          derandomize=not LONG)
settings.register_profile('compatibility', deadline=None, max_examples=7, derandomize=True,
                          suppress_health_check=[HealthCheck.data_too_large])
settings.load_profile(os.environ.get('HYPOTHESIS_PROFILE', 'project'))

# this package is not part of the project, and its tests need a ROS master
collect_ignore = ['src/multimaster_fkie']


def pytest_configure() -> None:
    """Keeps the garbage collector out of `ast.parse` under Python 3.11.

    Before 3.11.8, another thread may parse while the collector runs, for example a line of a
    traceback. Then the interrupted `ast.parse` raises SystemError (gh-106905 of CPython).
    """
    if sys.version_info[:2] != (3, 11):
        return
    parse = ast.parse

    @functools.wraps(parse)
    def parse_alone(*args: Any, **options: Any) -> ast.AST:
        was_enabled = gc.isenabled()
        gc.disable()
        try:
            return parse(*args, **options)
        finally:
            if was_enabled:
                gc.enable()

    pytest.MonkeyPatch().setattr(ast, 'parse', parse_alone)


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown() -> None:
    """Fails a test that leaves work behind: a periodic task of a node, or a server whose socket was
    closed before its loop had ended. (Such a loop never waits.)

    This work would run during all later tests of this process, take their time, and fill their
    memory with warnings.
    """
    owners = [getattr(getattr(thread, '_target', None), '__self__', None)
              for thread in threading.enumerate()]
    left = [owner for owner in owners if type(owner).__module__ == 'node_lifecycle.periodic'
            and not owner._ended.is_set()]
    for owner in left:
        owner.shutdown()
    deadline = time.monotonic() + 5.0
    while _closed_servers() and time.monotonic() < deadline:  # a thread may be about to end
        time.sleep(0.01)
    servers = _closed_servers()
    for server in servers:
        server.shutdown()
    if left or servers:
        pytest.fail(f'left behind: {[*(owner._name for owner in left), *servers]}', pytrace=False)


def _closed_servers() -> List[BaseServer]:
    """Returns the servers whose loop still runs in a thread although their socket is closed."""
    found = []
    for frame in sys._current_frames().values():
        caller: Optional[FrameType] = frame
        while caller is not None:
            if caller.f_code is BaseServer.serve_forever.__code__:
                server = caller.f_locals['self']
                found += [server] if server.fileno() < 0 else []
            caller = caller.f_back
    return found


# -- a disk that becomes full, read-only or missing ------------------------------------------------

Result = TypeVar('Result')
_MOUNTS = 0x20000  # CLONE_NEWNS


class SmallDisk:
    """A tmpfs of 2 MB. Only the thread that made it, and threads started by it, can see it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        if ctypes.CDLL(None, use_errno=True).unshare(_MOUNTS):
            pytest.skip(f'nothing can be mounted here ({os.strerror(ctypes.get_errno())})')
        try:
            _run('mount', '--make-rprivate', '/')
            _run('mount', '-t', 'tmpfs', '-o', 'size=2m', 'tmpfs', str(folder))
        except subprocess.CalledProcessError as error:
            pytest.skip(f'nothing can be mounted here ({error.stderr.strip()})')

    @contextlib.contextmanager
    def full(self) -> Iterator[None]:
        """Leaves no room for a single byte during the `with` block."""
        ballast = self.folder / 'ballast'
        with contextlib.suppress(OSError), ballast.open('wb', buffering=0) as file:
            while file.write(bytes(4096)):
                pass
        try:
            yield
        finally:
            ballast.unlink()

    @contextlib.contextmanager
    def read_only(self) -> Iterator[None]:
        """Makes the disk read-only during the block, as Linux does with a disk that gives errors.

        No file may be open for writing.
        """
        _run('mount', '-o', 'remount,ro', str(self.folder))
        try:
            yield
        finally:
            _run('mount', '-o', 'remount,rw', str(self.folder))

    @contextlib.contextmanager
    def gone(self) -> Iterator[None]:
        """Unmounts the disk during the block: its files are missing, and no file can be written
        there.
        """
        _run('mount', '-t', 'tmpfs', '-o', 'ro', 'tmpfs', str(self.folder))
        try:
            yield
        finally:
            _run('umount', str(self.folder))


def _run(*words: str) -> None:
    subprocess.run(words, check=True, capture_output=True, text=True)


@pytest.fixture
def on_small_disk(tmp_path: Path) -> Callable[[Callable[[SmallDisk], Result]], Result]:
    """Calls a function with a small disk, in a thread of its own."""
    def do(act: Callable[[SmallDisk], Result]) -> Result:
        with ThreadPoolExecutor(1) as thread:
            return thread.submit(lambda: act(SmallDisk(tmp_path))).result()
    return do
