"""Writes graphs that make_graph made. A seal shows whether a file was edited, so no edit is lost.
"""
from __future__ import annotations

import hashlib
import os
import re
from typing import Iterable

from file_replacement import replace_file
from graph_editor.errors import SiteError
from trajectory_graph import Graph
from trajectory_graph.yaml_file import dump_graph

_SEAL = re.compile(r'# made by make_graph, seal ([0-9a-f]{16})')
SEAL_MEANS = ('# While the seal matches the text below, make_graph may replace this file; an '
              'edited file is kept.')


def write_made_graph(graph: Graph, path: str, comments: Iterable[str], force: bool) -> None:
    """Writes a made graph.

    Without `force`, a file is not replaced if make_graph did not write it, or if it was edited.
    Raises SiteError.
    """
    if not force and os.path.exists(path) and not is_as_made(path):
        raise SiteError(f'{path} was made or edited by hand and is not overwritten: choose another '
                        'name, or give --force.')
    lines = [f'# {comment}' for comment in comments]
    body = '\n'.join(lines + [dump_graph(graph)])
    try:
        replace_file(path, f'# made by make_graph, seal {_seal(body)}\n{SEAL_MEANS}\n{body}')
    except OSError as error:
        raise SiteError(f'{path} cannot be written ({error.strerror}).') from None


def is_as_made(path: str) -> bool:
    """Returns whether the file is exactly as make_graph wrote it."""
    try:
        with open(path, encoding='utf-8', newline='') as stream:
            first, _, rest = stream.read().partition('\n')
    except (OSError, UnicodeDecodeError):
        return False
    sealed = _SEAL.fullmatch(first)
    return sealed is not None and sealed.group(1) == _seal(rest.partition('\n')[2])


def _seal(body: str) -> str:
    return hashlib.sha256(body.encode()).hexdigest()[:16]
