"""The slots that a robot's drive or wait blocks for other robots, as the searches need them.

The reservation table does not book places. It books the *beginnings of drives*. A robot may begin a
drive only while no other robot holds a conflicting place, and early enough to be out of the way of
the next robot. For each drive of one robot type, this module gives the slots that the drive blocks
for another type:

(slot, clear, lead): no robot may begin the drive `slot` in a time that starts `lead` seconds before
the blocking drive, and ends when the fraction `clear` of the blocking drive is driven. If `slot` is
for waiting, no robot may wait there in this time, and `lead` is 0.

`lead` is the time that the other robot needs to get out of the way of the blocking drive.
"""
from __future__ import annotations

from array import array
from functools import cached_property
from typing import Dict, Iterator, List, Mapping, NamedTuple, Tuple, cast

import numpy as np

from fleet_core.fleet import RobotType
from fleet_core.geometry.exclusions import Conflicts
from fleet_core.planning.road_network import RoadNetwork

Block = Tuple[int, float, float]
"""Slot, clear fraction, lead in s."""


class Meeting(NamedTuple):
    """A place of one robot that blocks a place of another robot.

    place -- of the robot that blocks
    clear -- if `place` is an edge: the fraction after which this robot is clear of the other place,
             driven forward and backward
    leads -- if the other place is an edge: the lead, as a share of a drive on it, forward and
             backward
    """

    place: int
    clear: Tuple[float, float]
    leads: Tuple[float, float]


class _Blocks(NamedTuple):
    """What each place blocks: a row of (slot, lead, clear fraction) for each place.

    The columns are arrays of Python, not of numpy, because short rows are read number by number.
    """

    rows: List[slice]     # of each place
    slots: array[int]
    leads: array[float]   # s
    clears: Tuple[array[float], array[float]]  # for a blocking edge: driven forward, and backward


class Blocking:
    """The slots that robots of the type `moving` block for robots of the type `observer`."""

    def __init__(self, network: RoadNetwork, moving: RobotType, observer: RobotType,
                 clearance: float) -> None:
        self._network = network
        self._distance = moving.reach + observer.reach + clearance
        times = np.array(network.times(observer))
        self._times = np.where(np.isfinite(times), times, 0.0)
        self._meeting: Dict[int, List[Meeting]] = {}

    @property
    def conflicts(self) -> Conflicts:
        """The places that exclude each other, and the fractions after which they are clear."""
        return self._network.exclusions.at(self._distance)

    def drive(self, drive: int) -> Iterator[Block]:
        """Returns the slots that a drive blocks, with the clear fraction and lead of each."""
        rows, slots, leads, clears = self._blocks
        row = rows[self._network.vertices + (drive >> 1)]
        return zip(slots[row], clears[drive & 1][row], leads[row])

    def edges(self, drive: int) -> Iterator[Tuple[int, float]]:
        """Returns (number of an edge, clear fraction) of all edges that a drive blocks."""
        rows, edges, clears = self._edge_blocks
        row = rows[drive >> 1]
        return zip(edges[row], clears[drive & 1][row])

    def seconds(self, drive: int) -> float:
        """Returns the seconds that a robot of the observer's type needs for a drive; 0: forbidden.
        """
        return float(self._times[drive])

    def meeting(self, place: int) -> List[Meeting]:
        """Returns the places of a moving robot that block this place of an observer."""
        if place not in self._meeting:
            conflicts = self.conflicts
            row = slice(conflicts.starts[place], conflicts.starts[place + 1])
            self._meeting[place] = list(map(
                Meeting, conflicts.row(place), conflicts.fractions(conflicts.transpose[row]),
                conflicts.fractions(row)))
        return self._meeting[place]

    def excluded(self, place: int) -> List[int]:
        """Returns the places (not slots) that an observer may not hold while a moving robot holds
        `place`.
        """
        return self.conflicts.row(place)

    def excludes(self, place: int, other: int) -> bool:
        """Returns whether these two places exclude each other for two robots."""
        return other in self.excluded(place)

    def wait(self, place: int) -> Iterator[Tuple[int, float]]:
        """Returns each (slot, lead) that a robot blocks while it is at `place`, a vertex or an
        edge.
        """
        rows, slots, leads, _ = self._blocks
        row = rows[place]
        return zip(slots[row], leads[row])

    def rest(self, drive: int, begun: float) -> List[int]:
        """Returns the places that an observer may not hold while a robot drives the rest of a
        drive, after the fraction `begun`.
        """
        starts, other, forward, backward, _ = self.conflicts
        edge = self._network.vertices + (drive >> 1)
        row = slice(starts[edge], starts[edge + 1])
        ahead = (forward, backward)[drive & 1][row] > begun
        return cast(List[int], other[row][ahead].tolist())

    def beside(self, near: Mapping[int, Tuple[float, float]]) -> List[Tuple[int, float]]:
        """Returns each (slot, lead) that a robot blocks while it stands too near to these places.

        near -- for each edge the part of it that is too near
        """
        blocked: List[Tuple[int, float]] = []
        for place, (low, high) in near.items():
            edge = place - self._network.vertices
            if edge < 0:
                blocked.append((self._network.vertex_slot(place), 0.0))
            else:
                blocked += [(drive, clear * float(self._times[drive]))
                            for drive, clear in ((2 * edge, high), (2 * edge + 1, 1.0 - low))]
        return blocked

    def prepare(self) -> None:
        """Computes the tables that `drive`, `edges` and `wait` otherwise compute at first use."""
        _ = self._blocks, self._edge_blocks

    @cached_property
    def _edge_blocks(self) -> Tuple[List[slice], array[int], Tuple[array[float], array[float]]]:
        """The edges that each edge blocks, as three lists: for each edge, the slice of its entries
        in the other lists; the numbers of the blocked edges; the clear fractions (forward and
        backward).
        """
        starts, other, forward, backward, _ = self.conflicts
        is_edge = other >= self._network.vertices
        bounds = np.concatenate(([0], np.cumsum(is_edge)))[starts[self._network.vertices:]].tolist()
        return ([slice(*ends) for ends in zip(bounds, bounds[1:])],
                array('q', (other[is_edge] - self._network.vertices).astype(np.int64).tobytes()),
                (array('d', forward[is_edge].tobytes()), array('d', backward[is_edge].tobytes())))

    @cached_property
    def _blocks(self) -> _Blocks:
        starts, other, forward, backward, mirrored = self.conflicts
        is_edge = other >= self._network.vertices
        # A blocked edge gets two blocks, one for each direction. A blocked vertex gets one block.
        count = np.where(is_edge, 2, 1)
        first = np.concatenate(([0], np.cumsum(count)))
        pair = np.repeat(np.arange(len(other)), count)
        slots = (other + self._network.drives)[pair]
        leads = np.zeros(len(slots))
        drive = 2 * (other[is_edge] - self._network.vertices)
        for direction, clear in enumerate((forward, backward)):
            at = first[:-1][is_edge] + direction
            slots[at] = drive + direction
            leads[at] = clear[mirrored[is_edge]] * self._times[drive + direction]
        bounds = first[starts].tolist()
        return _Blocks([slice(*ends) for ends in zip(bounds, bounds[1:])],
                       array('q', slots.tobytes()), array('d', leads.tobytes()),
                       (array('d', forward[pair].tobytes()), array('d', backward[pair].tobytes())))
