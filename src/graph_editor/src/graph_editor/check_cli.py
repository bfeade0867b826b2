"""The command line of `check_graph`, which prints the findings about a graph on its map, one per
line.

Exit status: 0 if there are no errors; 1 if there are errors, or if a file cannot be used; 2 for
wrong arguments. With --strict, warnings count as errors.
"""
from __future__ import annotations

import argparse
import sys
from typing import List, Optional

from graph_editor.checking.checker import Checker
from graph_editor.checking.findings import Severity
from graph_editor.checking.rules import CheckRules
from graph_editor.make_cli import (
    ERRORS,
    LoadMap,
    add_robot_arguments,
    add_site_arguments,
    site_options,
)
from graph_editor.picture import draw_graph
from graph_editor.site import load_site
from trajectory_graph import load_graph
from trajectory_graph.editing import Draft


def main(arguments: Optional[List[str]] = None, load: LoadMap = load_site) -> int:
    """Runs the command and returns its exit status; `load` reads the map of --map."""
    chosen = _parser().parse_args(arguments)
    try:
        graph = load_graph(chosen.graph)
        site = load(chosen.map, site_options(chosen))
        rules = CheckRules(robot_width=chosen.robot_width, robot_length=chosen.robot_length,
                           corridor=chosen.corridor)
        for note in site.notes:
            print(f'warning: {note}', file=sys.stderr)
        findings = Checker(rules, site).all(Draft.of(graph))
        if chosen.draw:
            draw_graph(site, graph, chosen.draw, chosen.corridor, findings)
    except ERRORS as error:
        print(f'error: {error}')
        return 1
    for finding in findings:
        print(finding)
    errors = sum(finding.severity is Severity.ERROR for finding in findings)
    print(f'{chosen.graph}: {errors} errors, {len(findings) - errors} warnings', file=sys.stderr)
    return 1 if errors or (findings and chosen.strict) else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='check_graph', description='Checks a trajectory graph against its map. It finds '
        'corridors in walls, vertices that robots cannot reach, bends that are too sharp, parking '
        'places that block edges, and more.')
    parser.add_argument('--graph', required=True, metavar='G.yaml', help='graph to check')
    add_site_arguments(parser)
    add_robot_arguments(parser)
    parser.add_argument('--strict', action='store_true', help='exit status 1 also for warnings')
    parser.add_argument('--draw', metavar='OUT.png', help='write a picture with the findings')
    return parser
