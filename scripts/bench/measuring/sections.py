"""Benchmarks in sections, each in its own process: a process can be only one ROS node."""
from __future__ import annotations

import argparse
import subprocess
import sys
from typing import Callable, Iterator, Mapping, Optional

from measuring.tables import Row, print_row, print_table


def print_sections(sections: Mapping[str, Callable[[], Iterator[Row]]],
                   description: Optional[str]) -> None:
    """Prints one table of all sections of the running program, or of the sections in --only."""
    options = argparse.ArgumentParser(description=description)
    options.add_argument('--only', choices=list(sections), action='append')
    chosen = options.parse_args().only or list(sections)
    if len(chosen) > 1:
        print_table([])
        for section in chosen:
            subprocess.run([sys.executable, sys.argv[0], '--only', section], check=True)
        return
    for row in sections[chosen[0]]():
        print_row(row)
