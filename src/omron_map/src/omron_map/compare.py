"""What differs between two maps of one place: objects added, removed, changed, and rows."""
from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import List, Tuple

import numpy as np

from omron_map.document import MapDocument
from omron_map.objects import MapObject
from omron_map.sections import sorted_rows


@dataclass(frozen=True)
class Difference:
    """What the new map has and the old has not, and the reverse.

    `changed` holds pairs of old and new objects of one name. Of points and lines only the numbers
    of rows are told.
    """

    added: Tuple[MapObject, ...]
    removed: Tuple[MapObject, ...]
    changed: Tuple[Tuple[MapObject, MapObject], ...]
    points_added: int
    points_removed: int
    lines_added: int
    lines_removed: int

    def __bool__(self) -> bool:
        return any(vars(self).values())


def compare(old: MapDocument, new: MapDocument) -> Difference:
    """The difference from `old` to `new`.

    Named objects are paired by name, upper or lower case; the others only when they are equal, so
    that an unnamed area that moved is one removed and one added.
    """
    removed, added = _unpaired(old, new), _unpaired(new, old)
    successors = {obj.key: obj for obj in reversed(added) if obj.name}
    changed = []
    for obj in removed:
        successor = successors.pop(obj.key, None) if obj.name else None
        if successor is not None:
            changed.append((obj, successor))
    return Difference(
        added=_without(added, [new_object for _, new_object in changed]),
        removed=_without(removed, [old_object for old_object, _ in changed]),
        changed=tuple(changed),
        points_added=_extra_rows(new.points, old.points),
        points_removed=_extra_rows(old.points, new.points),
        lines_added=_extra_rows(new.lines, old.lines),
        lines_removed=_extra_rows(old.lines, new.lines))


def _unpaired(one: MapDocument, other: MapDocument) -> List[MapObject]:
    """The objects of `one` that have no equal in `other`, each equal pairing only once."""
    left = Counter(other.objects)
    unpaired = []
    for obj in one.objects:
        if left[obj]:
            left[obj] -= 1
        else:
            unpaired.append(obj)
    return unpaired


def _without(objects: List[MapObject], taken: List[MapObject]) -> Tuple[MapObject, ...]:
    identities = {id(obj) for obj in taken}
    return tuple(obj for obj in objects if id(obj) not in identities)


def _extra_rows(rows: np.ndarray, others: np.ndarray) -> int:
    """How many different rows `rows` has that `others` has not."""
    either = sorted_rows(np.concatenate((rows, others)), once=True)
    return len(either) - len(sorted_rows(others, once=True))
