"""Changes that a fork must make before it runs the requested program."""
from __future__ import annotations

import ctypes
import gc
import io
import os
import runpy
import signal
import sys
import time
from typing import Iterable, Sequence

from node_host import ros_state
from node_host.start_request import StartRequest

PR_SET_PDEATHSIG, PR_SET_NAME = 1, 15
M_ARENA_MAX = -8
_LIBC = ctypes.CDLL(None)
ENDS = (signal.SIGINT, signal.SIGTERM)
"""Signals that a fork must not lose before it has its own handlers."""


def end_with(host: int) -> None:
    """Makes the kernel end this process when the process `host` ends for any reason."""
    _LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != host:
        os._exit(1)  # the host ended before the call of prctl


def restore_signals(mask: Iterable[int]) -> None:
    """Restores the signal handling of a new process. Signals that are pending take effect now."""
    for number in (*ENDS, signal.SIGCHLD):
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    signal.signal(signal.SIGINT, signal.default_int_handler)


def become(request: StartRequest, streams: Sequence[int]) -> None:
    """Starts a new session, and takes over the streams, folder, environment and arguments of a
    request.
    """
    os.setsid()
    for target, stream in enumerate(streams):
        os.dup2(stream, target)
        os.close(stream)
    os.chdir(request.folder)
    prepared = {key: os.environ[key] for key in (ros_state.CONFIGURATION,) if key in os.environ}
    os.environ.clear()
    os.environ.update({**prepared, **request.environment})
    sys.argv[:] = request.arguments
    time.tzset()
    for output in (sys.stdout, sys.stderr):
        assert isinstance(output, io.TextIOWrapper)
        output.reconfigure(line_buffering=output.isatty() or output is sys.stderr,
                           write_through='PYTHONUNBUFFERED' in os.environ)
    _show_as(request.arguments)
    _LIBC.mallopt(M_ARENA_MAX, 2)  # a node has a dozen threads, but little data
    _draw_other_random_numbers()
    ros_state.read_names()
    gc.enable()


def _show_as(arguments: Sequence[str]) -> None:
    """Shows the program's own command line in process lists, cut to the length of the host's line.
    """
    _LIBC.prctl(PR_SET_NAME, os.fsencode(os.path.basename(arguments[0])))
    with open('/proc/self/stat', encoding='utf-8') as stat:
        begin, end = map(int, stat.read().rsplit(')', 1)[1].split()[45:47])
    text = b'\0'.join(map(os.fsencode, arguments))[:end - begin - 1]
    ctypes.memmove(begin, text.ljust(end - begin, b'\0'), end - begin)


def _draw_other_random_numbers() -> None:
    """Seeds numpy's generator again: in a fork, Python does this only for its own generator."""
    numpy_random = sys.modules.get('numpy.random')
    if numpy_random is not None:
        numpy_random.seed()


def run_program() -> None:
    """Runs the program of `sys.argv` like the Python interpreter."""
    program = sys.argv[0]
    sys.path[0] = os.path.dirname(os.path.realpath(program))
    runpy.run_path(program, run_name='__main__')
