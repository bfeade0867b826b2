"""The output of lists: tables for people, which fit a terminal, and JSON for programs."""
from __future__ import annotations

import argparse
import json
import math
import textwrap
from typing import Any, List, Mapping, Optional, Sequence

from fleet_core.supervision.fleet_stop import FleetStop

WIDTH = 100     # columns of a table that fits
_SHORTEST = 8   # letters; a cell is never cut to a shorter length
_INDENT = '    '
_MORE = '...'


def offer_json(parser: argparse.ArgumentParser) -> None:
    """Adds the option --json to a list."""
    parser.add_argument('--json', action='store_true', help='for programs: all fields, as JSON')


def as_json(values: Mapping[str, Any]) -> str:
    """Returns the values as one JSON object."""
    return json.dumps(values, indent=1)


def for_about(seconds: float) -> str:
    """Returns how long something probably lasts, as the end of a clause; empty: unknown."""
    return f', for about {seconds:.0f} s' if math.isfinite(seconds) else ''


def stop_values(stop: FleetStop) -> Optional[Mapping[str, Any]]:
    """Returns a stop of the fleet as values for JSON; None: the fleet is not stopped."""
    return {'cause': stop.cause.name, 'by': stop.by, 'since': stop.since, 'why': stop.why
            } if stop.is_in_force else None


def table(rows: Sequence[Sequence[str]], width: Optional[int] = None) -> str:
    """Returns rows as text with aligned columns. The longest cells are cut to fit a `width`."""
    widths = _widths(rows, width)
    return '\n'.join(_line(row, widths) for row in rows)


def table_with_notes(head: Sequence[str], rows: Sequence[Sequence[str]],
                     notes: Sequence[str]) -> str:
    """Returns a table that fits WIDTH, with a note below each row; an empty note is left out."""
    widths = _widths((head, *rows), WIDTH)
    lines = [_line(head, widths)]
    for row, note in zip(rows, notes):
        lines += [_line(row, widths), *textwrap.wrap(
            note, WIDTH, initial_indent=_INDENT, subsequent_indent=_INDENT)]
    return '\n'.join(lines)


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    return '  '.join(_cut(cell, width).ljust(width)
                     for cell, width in zip(row, widths)).rstrip()


def _cut(cell: str, width: int) -> str:
    return cell if len(cell) <= width else cell[:width - len(_MORE)] + _MORE


def _widths(rows: Sequence[Sequence[str]], most: Optional[int]) -> List[int]:
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    while most is not None and sum(widths) + 2 * (len(widths) - 1) > most:
        widest = max(widths)
        if widest <= _SHORTEST:
            break
        widths[widths.index(widest)] -= 1
    return widths
