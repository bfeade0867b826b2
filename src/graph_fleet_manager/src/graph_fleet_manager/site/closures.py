"""Which edges are closed: kept in a file, for a closure outlives its sender and power cuts."""
from __future__ import annotations

import json
import os
from typing import Container, FrozenSet, Iterable, Union

from graph_fleet_manager.files.errors import FileError
from trajectory_graph.yaml_file import write_file

_AHEAD = 1_000_000_000  # ns that the clock of a computer that closes an edge may be ahead of ours


class Closures:
    """The closed edges in force and when they were said, in a file that need not be there yet.

    edges -- ids of the edges
    stamp -- ns of the ROS clock; 0: no edge was ever closed or opened

    Raises FileError for a file that is none of ours.
    """

    def __init__(self, file: Union[str, os.PathLike]) -> None:
        self._file = os.fspath(file)
        self.edges: FrozenSet[int] = frozenset()
        self.stamp = 0
        try:
            with open(self._file, encoding='utf-8') as stream:
                kept = json.load(stream)
            self.stamp, self.edges = int(kept['stamp']), frozenset(map(int, kept['edges']))
        except FileNotFoundError:
            pass
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise FileError(self._file, f'does not say which edges are closed ({error}); mend it, '
                            'or delete it and close them again') from None

    def take(self, edges: Iterable[int], stamp: int, now: int,
             known: Container[int]) -> FrozenSet[int]:
        """Puts these edges in force instead, on disk first; returns ids that the graph has not.

        stamp -- ns at which that was said; 0: now
        known -- ids of the graph's edges
        Raises OutOfDate for what was said before what is in force, OSError where the file cannot be
        written; then nothing has changed.
        """
        said = now if stamp == 0 or stamp > now + _AHEAD else stamp
        if stamp and said <= self.stamp:
            raise OutOfDate(self.stamp)
        wanted = frozenset(map(abs, edges))
        taken = frozenset(id for id in wanted if id in known)
        self._save(taken, said)
        return wanted - taken

    def forget_all_but(self, known: Container[int]) -> FrozenSet[int]:
        """Drops edges that a new graph does not have; returns them. Raises OSError."""
        gone = frozenset(id for id in self.edges if id not in known)
        if gone:
            self._save(self.edges - gone, self.stamp)
        return gone

    def _save(self, edges: FrozenSet[int], stamp: int) -> None:
        os.makedirs(os.path.dirname(os.path.abspath(self._file)), exist_ok=True)
        write_file(self._file, json.dumps({'stamp': stamp, 'edges': sorted(edges)}) + '\n')
        self.edges, self.stamp = edges, stamp


class OutOfDate(Exception):
    """A closure that was said before the one in force; `stamp` (ns) is that one's."""

    def __init__(self, stamp: int) -> None:
        super().__init__(f'It was said before the closure in force ({stamp / 1e9:.3f} s).')
        self.stamp = stamp
