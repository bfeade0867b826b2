"""What all unit tests share: how many examples hypothesis tries, and that none has a deadline, for
a loaded machine is no defect.

The same ones in every run, so that a change is judged by nothing but itself; many, and others each
time, with LD90_LONG_TESTS=1 (scripts/test.sh --long). With HYPOTHESIS_PROFILE=compatibility the
fewest of which every property's share is an example: for a second Python version, under which the
tests look for what does not work there at all.
"""
from __future__ import annotations

import contextlib
import ctypes
import os
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Callable, Iterator, TypeVar

import pytest
from hypothesis import HealthCheck, settings

LONG = os.environ.get('LD90_LONG_TESTS') == '1'

settings.register_profile('project', deadline=None, max_examples=500 if LONG else 60,
                          derandomize=not LONG)
settings.register_profile('compatibility', deadline=None, max_examples=7, derandomize=True,
                          suppress_health_check=[HealthCheck.data_too_large])
settings.load_profile(os.environ.get('HYPOTHESIS_PROFILE', 'project'))

collect_ignore = ['src/multimaster_fkie']     # not ours, and its tests need a ROS master


# -- a disk that gets full, or dies ---------------------------------------------------------------

Result = TypeVar('Result')
_MOUNTS = 0x20000  # CLONE_NEWNS


class SmallDisk:
    """A tmpfs of 2 MB. Only the thread that made it, and threads that this starts, see it.
    """

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
        """Without room for one byte more meanwhile."""
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
        """As Linux makes a disk that gives errors; needs that no file is open for writing."""
        _run('mount', '-o', 'remount,ro', str(self.folder))
        try:
            yield
        finally:
            _run('mount', '-o', 'remount,rw', str(self.folder))

    @contextlib.contextmanager
    def gone(self) -> Iterator[None]:
        """Its files are not found meanwhile, and nothing can be written in their place."""
        _run('mount', '-t', 'tmpfs', '-o', 'ro', 'tmpfs', str(self.folder))
        try:
            yield
        finally:
            _run('umount', str(self.folder))


def _run(*words: str) -> None:
    subprocess.run(words, check=True, capture_output=True, text=True)


@pytest.fixture
def on_small_disk(tmp_path: Path) -> Callable[[Callable[[SmallDisk], Result]], Result]:
    """Does something with a small disk, in a thread of its own."""
    def do(act: Callable[[SmallDisk], Result]) -> Result:
        with ThreadPoolExecutor(1) as thread:
            return thread.submit(lambda: act(SmallDisk(tmp_path))).result()
    return do
