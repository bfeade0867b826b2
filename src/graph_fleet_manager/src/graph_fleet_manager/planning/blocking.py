"""What a robot's drive or wait takes away from the others, slot by slot, ready for the searches.

Booked are not places but *beginnings of drives*: a robot may begin a drive only while nobody else
holds a conflicting place, and early enough to be out of the way of who comes next. For every drive
of one robot type this module gives the slots of another type that it blocks:

    (slot, clear, lead): from `lead` seconds before the drive begins, until the fraction `clear` of
                         it is driven, nobody may begin the drive `slot`, or (lead 0) wait there

`lead` is the time after which the other one would be clear of this drive in turn.
"""
from __future__ import annotations

from typing import List, Optional, Sequence, Tuple

import numpy as np

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.planning.exclusions import Conflicts
from graph_fleet_manager.planning.road_network import RoadNetwork

Block = Tuple[int, float, float]
"""Slot, clear fraction, lead in s."""

_EDGES_AT_ONCE = 64
_PREPARED = 2000000  # pairs of places: beyond them, rows are made when they are first needed


class Blocking:
    """What robots of type `mover` block for robots of type `observer`."""

    def __init__(self, network: RoadNetwork, mover: RobotType, observer: RobotType,
                 clearance: float) -> None:
        self._network = network
        self._distance = mover.reach + observer.reach + clearance
        times = np.array(network.times(observer))
        self._times = np.where(np.isfinite(times), times, 0.0)
        self._drives: List[Optional[List[Block]]] = [None] * network.drives
        self._waits: List[Optional[List[Tuple[int, float]]]] = [None] * network.vertices

    @property
    def conflicts(self) -> Conflicts:
        """The places that exclude each other, and for how long."""
        return self._network.exclusions.at(self._distance)

    def prepare(self) -> None:
        """Makes everything at once, unless the graph is so dense that it would take long."""
        if len(self.conflicts.other) <= _PREPARED:
            self._make(0, len(self.conflicts.starts) - 1)

    def drive(self, drive: int) -> List[Block]:
        """What driving blocks."""
        blocks = self._drives[drive]
        if blocks is None:
            first = self._network.vertices + (drive >> 1) // _EDGES_AT_ONCE * _EDGES_AT_ONCE
            self._make(first, min(first + _EDGES_AT_ONCE, len(self.conflicts.starts) - 1))
            blocks = self._drives[drive]
            assert blocks is not None
        return blocks

    def wait(self, vertex: int) -> List[Tuple[int, float]]:
        """(slot, lead) blocked by who waits at a vertex."""
        blocks = self._waits[vertex]
        if blocks is None:
            first = vertex // _EDGES_AT_ONCE * _EDGES_AT_ONCE
            self._make(first, min(first + _EDGES_AT_ONCE, self._network.vertices))
            blocks = self._waits[vertex]
            assert blocks is not None
        return blocks

    def excluded(self, place: int) -> List[int]:
        """The places (not slots) that an observer may not hold while a mover holds this one."""
        return self.conflicts.row(place)

    def excludes(self, place: int, other: int) -> bool:
        """May two robots not hold these two places at once?"""
        return other in self.excluded(place)

    def around_point(self, places: Sequence[int]) -> List[Tuple[int, float]]:
        """(slot, lead) blocked by who stands so near to these places that he excludes them."""
        return self._seen_by_other(np.array(places, dtype=np.int64))

    def of_place(self, place: int) -> List[Tuple[int, float]]:
        """(slot, lead) blocked by who may be anywhere on a place."""
        return self._seen_by_other(np.array(self.conflicts.row(place), dtype=np.int64))

    def _seen_by_other(self, places: np.ndarray) -> List[Tuple[int, float]]:
        """All slots of these places; a drive must be over before."""
        vertices = self._network.vertices
        waits = [(self._network.vertex_slot(v), 0.0) for v in places[places < vertices].tolist()]
        drives = [2 * e + way for e in (places[places >= vertices] - vertices).tolist()
                  for way in (0, 1)]
        return waits + [(drive, float(self._times[drive])) for drive in drives]

    def _make(self, first: int, last: int) -> None:
        """Fills in the rows of the places `first` to `last` - 1."""
        conflicts = self.conflicts
        begin, end = conflicts.starts[first], conflicts.starts[last]
        pairs = slice(begin, end)
        other, mirrored = conflicts.other[pairs], conflicts.transpose[pairs]
        vertices = self._network.vertices
        is_edge = other >= vertices
        forward_drive = np.where(is_edge, 2 * (other - vertices), 0)
        lead = np.zeros((2, len(other)))
        for k, clear in enumerate((conflicts.forward, conflicts.backward)):
            lead[k] = np.where(is_edge, clear[mirrored] * self._times[forward_drive + k], 0.0)
        # Every pair with an edge makes two blocks, one for each direction; with a vertex, one.
        slot = np.where(is_edge, forward_drive, other + self._network.drives)
        count = np.where(is_edge, 2, 1)
        which = np.repeat(np.arange(len(other)), count)
        way = np.zeros(len(which), dtype=np.int64)
        way[np.cumsum(count)[is_edge] - 1] = 1
        slots, leads = (slot[which] + way).tolist(), lead[way, which].tolist()
        clears = [clear[pairs][which].tolist()
                  for clear in (conflicts.forward, conflicts.backward)]
        offsets = np.concatenate(([0], np.cumsum(count)))
        bounds = offsets[conflicts.starts[first:last + 1] - begin].tolist()
        for place, low, high in zip(range(first, last), bounds, bounds[1:]):
            if place < vertices:
                self._waits[place] = list(zip(slots[low:high], leads[low:high]))
            else:
                drive = 2 * (place - vertices)
                for k in (0, 1):
                    self._drives[drive + k] = list(
                        zip(slots[low:high], clears[k][low:high], leads[low:high]))
