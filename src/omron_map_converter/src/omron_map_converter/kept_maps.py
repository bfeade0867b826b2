"""Keeps converted maps for later conversions of the same files, because fences take long to make.

The name of a kept map is the SHA-256 of everything on which the map depends: the graph, the base
map, the options, the source code of the conversion, and the versions of its libraries. So an
outdated map is never found. The first line of a file is the SHA-256 of its map, so that a damaged
map is not used.
"""
from __future__ import annotations

import contextlib
import hashlib
import os
import sys
from pathlib import Path
from typing import Iterator, Optional, Union

import numpy
import scipy
import shapely

import omron_map
import omron_map_converter
import trajectory_graph
from file_replacement import replace_file
from omron_map_converter.converter import ConversionOptions, convert_file
from trajectory_graph import Graph
from trajectory_graph.yaml_file import dump_graph

MOST = 20
"""The largest number of kept maps. If there are more, the least recently used ones are removed."""

Folder = Union[str, 'os.PathLike[str]']


def folder_of_this_user() -> Path:
    """Returns the folder of kept maps of the user who runs this process."""
    caches = os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache'
    return Path(caches) / 'omron_map_converter'


def convert_or_copy(graph: Graph, base_map: str, output: str, options: ConversionOptions,
                    folder: Folder) -> None:
    """Makes the map `output` as `convert_file` does, or copies the map kept in `folder`.

    A folder that cannot be read or written keeps nothing. Raises ConversionError, MapError, and
    OSError if `output` cannot be written.
    """
    kept = Path(folder) / f'{_key(graph, base_map, options)}.map'
    content = _intact(kept)
    if content is not None:
        replace_file(output, content)
        return
    convert_file(graph, base_map, output, options)
    made = Path(output).read_bytes()
    with contextlib.suppress(OSError):
        kept.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        replace_file(kept, _digest(made) + b'\n' + made, mode=0o600, on_disk=False)
        _remove_oldest(kept.parent)


def _key(graph: Graph, base_map: str, options: ConversionOptions) -> str:
    """Returns the SHA-256 of everything on which the map depends."""
    whole = hashlib.sha256()
    with contextlib.suppress(OSError):  # the conversion reports an unreadable base map
        whole.update(_digest(Path(base_map).read_bytes()))
    for part in (dump_graph(graph), repr(options), *_versions()):
        whole.update(_digest(part.encode()))
    return whole.hexdigest()


def _versions() -> Iterator[str]:
    """Yields the versions of all code that makes a map."""
    geos = getattr(shapely, 'geos_version', None) or shapely.geos.geos_version  # before Shapely 2
    yield from (sys.version, numpy.__version__, scipy.__version__, shapely.__version__, repr(geos))
    for package in (omron_map, omron_map_converter, trajectory_graph):
        for folder in package.__path__:
            for source in sorted(Path(folder).rglob('*.py')):
                yield source.read_text(encoding='utf-8')


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


def _intact(kept: Path) -> Optional[bytes]:
    """Returns a kept map and marks it as used; None: there is none, or it is damaged."""
    try:
        digest, _, content = kept.read_bytes().partition(b'\n')
        if digest != _digest(content):
            return None
        os.utime(kept)
    except OSError:
        return None
    return content


def _remove_oldest(folder: Path) -> None:
    """Removes the maps above `MOST`; raises OSError."""
    maps = sorted(folder.glob('*.map'), key=lambda one: one.stat().st_mtime)
    for one in maps[:-MOST]:
        one.unlink()
