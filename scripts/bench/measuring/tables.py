"""Prints Markdown tables, in the form of docs/performance.md."""
from __future__ import annotations

from typing import Iterable, NamedTuple, Sequence


class Row(NamedTuple):
    """One line of a table."""

    what: str
    figure: str
    floor: str = ''
    aim: str = ''


HEADINGS = Row('what', 'figure', 'floor in the same run', 'aim')


def print_table(rows: Iterable[Sequence[str]], headings: Sequence[str] = HEADINGS) -> None:
    """Prints each row as soon as it is measured."""
    print_row(headings)
    print_row(['---'] * len(headings))
    for row in rows:
        print_row(row)


def print_row(cells: Sequence[str]) -> None:
    """Prints one line at once."""
    print(f'| {" | ".join(cells)} |', flush=True)
