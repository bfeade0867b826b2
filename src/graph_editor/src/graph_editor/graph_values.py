"""Prints single values of a graph, for scripts.

Usage: python3 -m graph_editor.graph_values NAME GRAPH [MAP]. The values of NAME:

unedited     no value; the exit status is 0 if the file is as make_graph wrote it
dock         the vertex id of the dock, the lowest if there are several; empty line: no dock
edge_widths  ID=WIDTH (m) of each edge without space for a whole corridor, for omron_ros_map
"""
from __future__ import annotations

import sys
from typing import List

from graph_editor.checking.checker import narrow_edges
from graph_editor.graph_files import is_as_made
from graph_editor.make_cli import ERRORS
from graph_editor.making.options import MakingOptions
from graph_editor.site import SiteOptions, load_site
from trajectory_graph import load_graph


def main(arguments: List[str]) -> int:
    """Prints the value and returns 0. If a file cannot be used, prints why and returns 1."""
    name, graph_file, *rest = arguments
    try:
        if name == 'unedited':
            return 0 if is_as_made(graph_file) else 1
        graph = load_graph(graph_file)
        if name == 'dock':
            docks = [vertex.id for vertex in graph.vertices.values() if vertex.dock]
            print(min(docks, default=''))
        else:
            options = MakingOptions()
            floor = load_site(rest[0], SiteOptions()).floor
            narrow = narrow_edges(graph, floor, options.corridor, options.robot_width)
            print(','.join(f'{id}={width:.2f}' for id, width in sorted(narrow.items())))
    except ERRORS as error:
        print(f'error: {error}', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
