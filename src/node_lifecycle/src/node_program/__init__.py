"""Starts a program: the one thing to be done before its modules are imported.

Apart from `node_lifecycle`, and without an import of ROS, because it has to come first.
"""
from __future__ import annotations

import os
import signal
import sys
from importlib import import_module
from typing import Callable, List

INTERRUPTED = 130  # the exit status of what was ended by Ctrl-C, as shells have it
_when_started: List[Callable[[], None]] = []


def when_started(then: Callable[[], None]) -> None:
    """Calls `then` once, as soon as the node of this process has started."""
    _when_started.append(then)


def tell_started() -> None:
    """The node of this process has started: it has registered with the ROS master."""
    while _when_started:
        _when_started.pop()()


def run_main(module: str) -> None:
    """For a node: imports the module and calls its `main()`, whose result is the exit status.

    Until the node itself takes signals, SIGINT ends the program at once. As an exception it can be
    swallowed where libraries are imported: the node would still start, and roslaunch would
    wait 15 s for it to end.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(import_module(module).main())


def run_command(module: str, function: str = 'main') -> None:
    """For a command: the same, but Ctrl-C ends it silently, with exit status 130, at any time.

    `main` gets KeyboardInterrupt, so that it can put things in order; before and after it nothing
    does.
    """
    signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))
    main = getattr(import_module(module), function)
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        status = main()
        signal.signal(signal.SIGINT, lambda *_: os._exit(INTERRUPTED))
    except KeyboardInterrupt:
        status = INTERRUPTED
    sys.exit(status)
