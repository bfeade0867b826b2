"""`node_host MODULE...`: imports these modules once, then forks programs for `hosted`.

The host itself is not a ROS node. A module that cannot be imported is reported and skipped. A
program that needs such a module tries to import it again.
"""
from __future__ import annotations

import gc
import importlib
import os
import resource
import socket
import sys
from typing import Optional, Sequence

from node_host import child, ros_state, shared_memory
from node_host.address import host_address
from node_host.host import Host
from node_host.start_queue import StartQueue

OPEN_FILES = 16384
ONE_THREAD = {'OPENBLAS_NUM_THREADS': '1', 'OMP_NUM_THREADS': '1', 'MKL_NUM_THREADS': '1'}


def main() -> Optional[int]:
    """Runs the host; in a fork it runs the requested program."""
    gc.disable()  # forks share memory that the collector does not touch
    _allow_files()
    os.environ.update(ONE_THREAD)  # a fork would not inherit further threads
    _import([one for one in sys.argv[1:] if ':=' not in one])
    ros_state.prepare()
    gc.collect()
    shared_memory.fill_holes()
    gc.freeze()
    return serve()


def _allow_files() -> None:
    """Raises the limit of open files, because the host has two open files for each program."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = OPEN_FILES if hard == resource.RLIM_INFINITY else min(OPEN_FILES, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def serve() -> Optional[int]:
    """Serves requests until a signal ends the host; in a fork, runs the requested program."""
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    try:
        listener.bind(host_address())
    except OSError:
        print('This launch has a node host already: start only one.', file=sys.stderr)
        return 1
    listener.listen(socket.SOMAXCONN)
    if Host(listener, StartQueue()).serve():
        child.run_program()
    return None


def _import(modules: Sequence[str]) -> None:
    for module in modules:
        try:
            importlib.import_module(module)
        except ImportError as error:
            print(f'[node_host] {module} cannot be imported ({error}).', file=sys.stderr,
                  flush=True)
