"""`ld_map`: looks into `.map` files and converts them, without ROS.

Exit status: 0 when done (for `diff`: no difference), 1 when a file cannot be used or maps differ,
2 for wrong arguments. What a map holds of the robot's configuration is never printed: there are
passwords and host addresses in it.
"""
from __future__ import annotations

import argparse
import sys
from typing import List, Optional

from omron_ld90.maps.document import MapDocument
from omron_ld90.maps.errors import MapError


def main(arguments: Optional[List[str]] = None) -> int:
    """Run the command and return its exit status."""
    options = _parser().parse_args(arguments)
    try:
        return options.run(options)
    except MapError as error:
        print(error, file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='ld_map', description='Looks into .map files.')
    commands = parser.add_subparsers(dest='command', required=True, metavar='COMMAND')
    command = commands.add_parser('check', help='tell whether files load, and what is odd')
    command.add_argument('files', nargs='+', metavar='FILE')
    command.set_defaults(run=_check)
    return parser


def _check(options: argparse.Namespace) -> int:
    failed = False
    for path in options.files:
        try:
            document = MapDocument.load(path)
        except MapError as error:
            print(error, file=sys.stderr)
            failed = True
            continue
        for warning in document.warnings:
            print(f'{path}: warning: {warning}')
        print(f'{path}: ok')
    return int(failed)
