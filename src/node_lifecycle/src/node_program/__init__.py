"""Starts a program, after the work that must come before the import of the program's modules.

It is separate from `node_lifecycle` and does not import ROS, because it must run first.
"""
from __future__ import annotations

import os
import signal
import sys
from importlib import import_module
from typing import Callable, List

from node_program.inert_text import make_output_inert

INTERRUPTED = 130  # exit status of a program ended by Ctrl-C, as in shells
PRIVATE = 0o077    # umask of nodes
_when_started: List[Callable[[], None]] = []


def when_started(then: Callable[[], None]) -> None:
    """Calls `then` once, as soon as the node of this process has started."""
    _when_started.append(then)


def node_started() -> None:
    """Notes that the node of this process has started and registered with the ROS master."""
    while _when_started:
        _when_started.pop()()


def run_main(module: str) -> None:
    """Runs a node: imports the module and calls its `main()`, whose result is the exit status.

    Until the node handles SIGINT itself, SIGINT ends the program at once. If SIGINT raised an
    exception, an import could swallow it. Then the node would still start, and roslaunch would wait
    15 s for its end. Only the node's own user may read files that the node makes.
    """
    os.umask(PRIVATE)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(import_module(module).main())


def run_command(module: str, function: str = 'main') -> None:
    """Runs a command: like `run_main`, but Ctrl-C ends it silently, with exit status 130.

    During `main`, Ctrl-C raises KeyboardInterrupt, so that `main` can clean up. Before and after
    `main`, Ctrl-C ends the process at once. Control characters in the output are escaped, because
    reasons and names come from other programs.
    """
    make_output_inert()
    signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))
    main = getattr(import_module(module), function)
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        status = main()
        signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))
    except KeyboardInterrupt:
        status = INTERRUPTED
    sys.exit(status)
