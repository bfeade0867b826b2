"""Starts a node's program: the one thing to be done before a node's modules are imported.

Apart from `node_lifecycle`, and without an import of ROS, because it has to come first.
"""
from __future__ import annotations

import signal
import sys
from importlib import import_module


def run_main(module: str) -> None:
    """Imports the module and calls its `main()`, whose result is the exit status.

    Until the node itself takes signals, SIGINT ends the program at once. As an exception it can be
    swallowed where libraries are imported: the node would start all the same, and roslaunch would
    wait 15 s for it to end.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(import_module(module).main())
