"""Which edges are closed: kept in a file, for a closure outlives its sender and power cuts.

An operation opens or closes edges and leaves all others as they are. Operations count in the order
in which they arrive; no clock decides on them. A list of all closed edges replaces all that was
closed, so one that was said before the last change is out of date.
"""
from __future__ import annotations

import json
import os
from dataclasses import dataclass
from enum import IntEnum
from typing import Container, FrozenSet, Iterable, Optional, Tuple, Union

from file_replacement import replace_file
from graph_fleet_manager.files.errors import FileError

_AHEAD = 1_000_000_000  # ns that the clock of a computer that closes an edge may be ahead of ours
_REMEMBERED = 1000      # operations that are known again when their message comes once more


class EdgeAction(IntEnum):
    """What an operation does; as in itrci_nav_msgs/EdgeCommand."""

    OPEN = 0
    CLOSE = 1


@dataclass(frozen=True)
class EdgeOperation:
    """Opens or closes edges.

    edges    -- ids
    identity -- of the message: one that comes again, as latched ones do after a broken connection,
                has the same; empty: no message comes again
    """

    action: EdgeAction
    edges: FrozenSet[int]
    identity: str = ''


class Closures:
    """The closed edges in force and when they last changed, in a file that need not be there yet.

    edges -- ids of the edges
    stamp -- ns of the ROS clock; 0: no edge was ever closed or opened

    Where a method takes the `known` ids of the graph's edges, others are not closed; None: there is
    no graph, and every id may be one of its edges. Raises FileError for a file that is none of
    ours. Methods raise OSError where the file cannot be written; then nothing has changed.
    """

    def __init__(self, file: Union[str, os.PathLike]) -> None:
        self._file = os.fspath(file)
        self.edges: FrozenSet[int] = frozenset()
        self.stamp = 0
        self._carried_out: Tuple[str, ...] = ()
        try:
            with open(self._file, encoding='utf-8') as stream:
                kept = json.load(stream)
            self.stamp, self.edges = int(kept['stamp']), frozenset(map(int, kept['edges']))
            self._carried_out = tuple(map(str, kept.get('carried_out', ())))
        except FileNotFoundError:
            pass
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise FileError(self._file, f'does not say which edges are closed ({error}); mend it, '
                            'or delete it and close them again') from None

    def apply(self, operation: EdgeOperation, now: int,
              known: Optional[Container[int]]) -> FrozenSet[int]:
        """Carries out an operation, on disk first; returns ids that the graph has not.

        now -- ns of the ROS clock
        Raises Repeated for a message that was carried out before.
        """
        if operation.identity in self._carried_out:
            raise Repeated
        unknown = _unknown(operation.edges, known)
        edges = (self.edges - operation.edges if operation.action is EdgeAction.OPEN
                 else self.edges | (operation.edges - unknown))
        carried_out = self._carried_out
        if operation.identity:
            carried_out = (*carried_out, operation.identity)[-_REMEMBERED:]
        self._save(edges, max(now, 0), carried_out)
        return unknown

    def take(self, edges: Iterable[int], stamp: int, now: int,
             known: Optional[Container[int]]) -> FrozenSet[int]:
        """Puts this list in force instead, on disk first; returns ids that the graph has not.

        stamp -- ns at which that was said; 0: now
        Raises OutOfDate for what was said before what is in force.
        """
        said = now if stamp == 0 or stamp > now + _AHEAD else stamp
        was_set_back = self.stamp > now + _AHEAD  # our clock, since the last change
        if stamp and said <= self.stamp and not was_set_back:
            raise OutOfDate(self.stamp)
        wanted = frozenset(map(abs, edges))
        unknown = _unknown(wanted, known)
        self._save(wanted - unknown, said, self._carried_out)
        return unknown

    def forget_all_but(self, known: Container[int]) -> FrozenSet[int]:
        """Drops edges that a new graph does not have; returns them."""
        gone = _unknown(self.edges, known)
        if gone:
            self._save(self.edges - gone, self.stamp, self._carried_out)
        return gone

    def _save(self, edges: FrozenSet[int], stamp: int, carried_out: Tuple[str, ...]) -> None:
        os.makedirs(os.path.dirname(os.path.abspath(self._file)), exist_ok=True)
        replace_file(self._file, json.dumps({'stamp': stamp, 'edges': sorted(edges),
                                             'carried_out': carried_out}) + '\n')
        self.edges, self.stamp, self._carried_out = edges, stamp, carried_out


class OutOfDate(Exception):
    """A list that was said before the last change; `stamp` (ns) is that one's."""

    def __init__(self, stamp: int) -> None:
        super().__init__(f'It was said before the closure in force ({stamp / 1e9:.3f} s).')
        self.stamp = stamp


class Repeated(Exception):
    """An operation whose message was carried out before."""


def _unknown(edges: FrozenSet[int], known: Optional[Container[int]]) -> FrozenSet[int]:
    return frozenset() if known is None else frozenset(id for id in edges if id not in known)
