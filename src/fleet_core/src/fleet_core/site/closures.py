"""The closed edges, kept in a file so that they outlast power cuts and the end of their sender.

An operation opens or closes edges and leaves all others as they are. Operations are carried out in
the order of their arrival, regardless of their stamps. A list of all closed edges replaces the
closures in force, so a list that is older than the last change is out of date.
"""
from __future__ import annotations

import json
import os
from dataclasses import dataclass
from enum import IntEnum
from typing import Container, FrozenSet, Iterable, Optional, Tuple, Union

from file_replacement import replace_file
from fleet_core.files.errors import FileError

_AHEAD = 1_000_000_000  # ns by which the clock of a sender may be ahead of this computer's
_REMEMBERED = 1000      # number of last operations that are recognised if their messages come again


class EdgeAction(IntEnum):
    """The kind of an operation, with the numbers of itrci_nav_msgs/EdgeCommand."""

    OPEN = 0
    CLOSE = 1


@dataclass(frozen=True)
class EdgeOperation:
    """Opens or closes edges.

    edges    -- ids of the edges
    identity -- identifies the message. So a message that arrives again is recognised, for example
                a latched one after a broken connection; empty: it is always carried out
    """

    action: EdgeAction
    edges: FrozenSet[int]
    identity: str = ''


class Closures:
    """The closed edges in force and the time of their last change. The file need not exist yet.

    State: the edges, the stamp, and the identities of the last operations. Events: an operation, a
    list of all closed edges, a new graph. Invariants: the file is written before the state changes;
    the stamp grows unless the clock was set back; no operation is carried out twice.

    edges -- ids of the edges
    stamp -- ns of the ROS clock; 0: no edge was ever closed or opened

    The argument `known` of the methods has the ids of the graph's edges. Other edges are not
    closed. If it is None, there is no graph, and every id is accepted.

    Raises FileError if the content of the file is not valid. Methods raise OSError if the file
    cannot be written; then nothing has changed.
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
            raise FileError(self._file, f'does not say which edges are closed ({error}); correct '
                            'it, or delete it and close the edges again') from None

    def apply(self, operation: EdgeOperation, now: int,
              known: Optional[Container[int]]) -> FrozenSet[int]:
        """Carries out an operation, on disk first. Returns the ids that the graph does not have.

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

    def replace(self, edges: Iterable[int], stamp: int, now: int,
                known: Optional[Container[int]]) -> FrozenSet[int]:
        """Replaces the closed edges, on disk first. Returns the ids that the graph does not have.

        stamp -- ns of the ROS clock at which the list was sent; 0: now
        now   -- ns of the ROS clock
        Raises OutOfDate for a list that is older than the last change.
        """
        said = now if stamp == 0 or stamp > now + _AHEAD else stamp
        was_set_back = self.stamp > now + _AHEAD  # the clock was set back after the last change
        if stamp and said <= self.stamp and not was_set_back:
            raise OutOfDate(self.stamp)
        wanted = frozenset(map(abs, edges))
        unknown = _unknown(wanted, known)
        self._save(wanted - unknown, said, self._carried_out)
        return unknown

    def forget_all_but(self, known: Container[int]) -> FrozenSet[int]:
        """Removes the closures of edges that a new graph does not have. Returns these edges."""
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
    """A list is older than the last change. `stamp` (ns) is the time of that change."""

    def __init__(self, stamp: int) -> None:
        super().__init__(f'It is older than the last change ({stamp / 1e9:.3f} s).')
        self.stamp = stamp


class Repeated(Exception):
    """The message of an operation was carried out before."""


def _unknown(edges: FrozenSet[int], known: Optional[Container[int]]) -> FrozenSet[int]:
    return frozenset() if known is None else frozenset(id for id in edges if id not in known)
