"""Finds the differences between two maps of the same place: objects, points and lines."""
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
    """The differences between an old and a new map.

    added, removed -- objects that only the new map has, and objects that only the old map has
    changed        -- pairs of the old and the new object with the same name
    points_added ... lines_removed -- numbers of rows
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
    """Returns the difference from `old` to `new`.

    Named objects are paired by name, without regard to case. Unnamed objects are paired only if
    they are equal, so an unnamed area that moved counts as one removed and one added area.
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
    """Returns the objects of `one` that have no equal object in `other`.

    An object of `other` pairs with at most one object.
    """
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
    """Returns the number of distinct rows of `rows` that `others` does not have."""
    either = sorted_rows(np.concatenate((rows, others)), once=True)
    return len(either) - len(sorted_rows(others, once=True))
