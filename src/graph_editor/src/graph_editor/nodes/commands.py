"""The commands `make_graph` and `check_graph`, which can also read maps from topics."""
from __future__ import annotations

from graph_editor import check_cli, make_cli
from graph_editor.nodes.live_map import load_map


def make_graph() -> int:
    """Makes a graph from a map; returns the exit status."""
    return make_cli.main(load=load_map)


def check_graph() -> int:
    """Checks a graph against its map; returns the exit status."""
    return check_cli.main(load=load_map)
