"""The command `split_edges`: it cuts the long edges of a graph into sections."""
from __future__ import annotations

import argparse
import math
import sys
from typing import Optional, Sequence

from trajectory_graph.errors import GraphError
from trajectory_graph.splitting import split_edges
from trajectory_graph.yaml_file import load_graph, save_graph

MOST_SECTIONS = 100000


def split_edges_main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command and returns the exit status.

    0: the file is written; 1: it is not written, and stderr has one sentence; 130: Ctrl-C.
    """
    parser = argparse.ArgumentParser(
        prog='split_edges',
        description='Cuts the long edges of a trajectory graph into equal sections with new '
                    'vertices between them, so that more robots can share the graph.')
    parser.add_argument('--longest', type=_length, required=True, metavar='METRES',
                        help='the greatest length of a section')
    parser.add_argument('graph', help='the trajectory graph (YAML)')
    parser.add_argument('output', help='the file to write; may be the same file as the graph')
    options = parser.parse_args(arguments)
    try:
        graph = load_graph(options.graph)
        sections = sum(graph.curve(edge).length for edge in graph.edges) / options.longest
        if sections > MOST_SECTIONS:
            print(f'{options.graph} would have {sections:.0f} sections of {options.longest} m; '
                  f'choose a greater length, for at most {MOST_SECTIONS}.', file=sys.stderr)
            return 1
        split = split_edges(graph, options.longest)
        save_graph(split, options.output,
                   f'{options.graph} with edges of at most {options.longest} m.')
    except GraphError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    except OSError as error:
        print(f'{options.output} cannot be written: {error.strerror}.', file=sys.stderr)
        return 1
    print(f'{options.output}: {len(split.vertices)} vertices and {len(split.edges)} edges; '
          f'before: {len(graph.vertices)} and {len(graph.edges)}.')
    return 0


def _length(text: str) -> float:
    value = float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f'{text} is not a length above 0')
    return value
