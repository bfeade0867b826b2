"""The command line of `check_graph`: what is wrong with a graph on its map, one line a finding.

Exit status: 0 when nothing is wrong, 1 when something is (with --strict, warnings count, too), or
when a file cannot be used; 2 for wrong arguments.
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
    """Run the command and return its exit status; `load` reads what --map names."""
    chosen = _parser().parse_args(arguments)
    try:
        graph = load_graph(chosen.graph)
        site = load(chosen.map, site_options(chosen))
        rules = CheckRules(robot_width=chosen.robot_width, robot_length=chosen.robot_length,
                           corridor=chosen.corridor)
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
        prog='check_graph', description='Checks a trajectory graph against its map: corridors in '
        'walls, vertices that cannot be reached, bends too sharp, parking in the way, ...')
    parser.add_argument('--graph', required=True, metavar='G.yaml', help='graph to check')
    add_site_arguments(parser)
    add_robot_arguments(parser)
    parser.add_argument('--strict', action='store_true', help='exit status 1 for warnings, too')
    parser.add_argument('--draw', metavar='OUT.png', help='picture with the findings to draw')
    return parser
