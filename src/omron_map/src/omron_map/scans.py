"""The scans of a map: points and lines in mm, with the header's values about them."""
from __future__ import annotations

from typing import Iterable, List, Optional, Tuple

import numpy as np

from omron_map.header import ScanHeader
from omron_map.sections import COLUMNS, Section


class Scan:
    """One scan source: its `points` (N, 2) and `lines` (M, 4), int32, in mm."""

    def __init__(self, header: ScanHeader, sections: List[Section], first: bool) -> None:
        self.name = header.source
        self.header = header
        names = ('', self.name.lower()) if first else (self.name.lower(),)
        own = [section for section in sections if section.source.lower() in names]
        self.points = _join(own, 'DATA')
        self.lines = _join(own, 'LINES')

    @property
    def resolution(self) -> Optional[int]:
        """The grid pitch of the points in mm; None if the file gives none."""
        pitch = self.header.values.get('Resolution', 0)
        return pitch if pitch > 0 else None


def scans_of(headers: Iterable[ScanHeader], sections: List[Section]) -> Tuple[Scan, ...]:
    """Returns the scan of each header; sections without a name belong to the first scan."""
    return tuple(Scan(header, sections, index == 0) for index, header in enumerate(headers))


def _join(sections: List[Section], kind: str) -> np.ndarray:
    blocks = [section.rows for section in sections if section.kind == kind]
    if len(blocks) == 1:
        return blocks[0]
    return np.concatenate([np.empty((0, len(COLUMNS[kind])), np.int32)] + blocks)
