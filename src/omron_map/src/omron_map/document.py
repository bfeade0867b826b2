"""A `.map` file: its original bytes and their meaning.

The document keeps the raw lines together with the values read from them. An unchanged line is
written back from its bytes. So reading and saving without an edit gives the same file; this matters
because a checksum of all bytes identifies a map. All lengths are in mm and all angles in degrees,
in the map frame.
"""
from __future__ import annotations

import os
from typing import Iterable, List, Optional, Tuple

import numpy as np

from omron_map import editing, scan_editing
from omron_map.checks import check
from omron_map.errors import FieldError, MapError, MapWarning
from omron_map.objects import MapObject
from omron_map.reader import MapContent, Record, check_category, read_content, read_headers
from omron_map.regular_file import read_regular_file
from omron_map.saving import write_file
from omron_map.scans import scans_of
from omron_map.sections import Section


class MapDocument:
    """A map that can be read, edited and saved.

    Edits change the document in place, but no more lines than necessary. An edit that cannot be
    done raises MapError and changes nothing. `name` is the name of the file in errors.

    It has a method for each kind of content and for each edit, because edits keep the layout of the
    whole file.
    """

    def __init__(self, content: MapContent, name: str) -> None:
        self.name = name
        self._records = content.records
        self._sections = content.sections
        self.scans = scans_of(content.headers, content.sections)
        self._notes: List[editing.Note] = []

    @classmethod
    def load(cls, path: str) -> MapDocument:
        """Returns the map in the regular file `path`; raises MapError.

        If the file is not a map, only its beginning is read, and the error does not quote it.
        """
        name = os.fspath(path)
        data = read_regular_file(name, accept=lambda head: check_category(head, name))
        return cls.from_bytes(data, name)

    @classmethod
    def from_bytes(cls, data: bytes, name: str = 'map') -> MapDocument:
        """Returns the map whose file has the contents `data`; raises MapError."""
        return cls(read_content(data, name), name)

    def to_bytes(self) -> bytes:
        """Returns the bytes of the file; without an edit they are the bytes that were read."""
        return b''.join([record.raw for record in self._records]
                        + [section.raw for section in self._sections])

    def save(self, path: str, backup: bool = False) -> None:
        """Writes the file `path` in one step; `backup` keeps the old file as `<path>.bak`."""
        write_file(os.fspath(path), self.to_bytes(), backup)

    @property
    def category(self) -> str:
        """The first line, e.g. `2D-Map`; it does not depend on the contents of the map."""
        return next(r.raw for r in self._records if r.keyword).decode('utf-8-sig').strip()

    @property
    def records(self) -> Tuple[Record, ...]:
        """All metadata lines in file order; the first is line 1."""
        return tuple(self._records)

    @property
    def sections(self) -> Tuple[Section, ...]:
        """The LINES and DATA sections in file order."""
        return tuple(self._sections)

    @property
    def objects(self) -> Tuple[MapObject, ...]:
        """The active objects in file order."""
        return tuple(record.object for record in self._records if record.object is not None)

    @property
    def goals(self) -> Tuple[MapObject, ...]:
        """Goals of every kind, with and without heading."""
        return tuple(obj for obj in self.objects if obj.is_goal)

    @property
    def docks(self) -> Tuple[MapObject, ...]:
        """Docks of every kind, such as `Dock` and `DockLynx`."""
        return tuple(obj for obj in self.objects if obj.is_dock)

    @property
    def homes(self) -> Tuple[MapObject, ...]:
        """RobotHome points and rectangles."""
        return tuple(obj for obj in self.objects if obj.is_home)

    @property
    def forbidden_areas(self) -> Tuple[MapObject, ...]:
        """Rectangles that the robot must stay out of."""
        return tuple(obj for obj in self.objects if obj.kind == 'ForbiddenArea')

    @property
    def forbidden_lines(self) -> Tuple[MapObject, ...]:
        """Lines that the robot must not cross."""
        return tuple(obj for obj in self.objects if obj.kind == 'ForbiddenLine')

    @property
    def sectors(self) -> Tuple[MapObject, ...]:
        """Areas that change the robot's driving: all areas except forbidden areas and homes."""
        return tuple(obj for obj in self.objects
                     if obj.is_area and obj.kind != 'ForbiddenArea' and not obj.is_home)

    @property
    def points(self) -> np.ndarray:
        """(N, 2) int32 scan points in mm, of all scans in file order."""
        return _all([scan.points for scan in self.scans])

    @property
    def lines(self) -> np.ndarray:
        """(M, 4) int32 wall lines x1, y1, x2, y2 in mm, of all scans in file order."""
        return _all([scan.lines for scan in self.scans])

    @property
    def resolution(self) -> Optional[int]:
        """Grid pitch of the points in mm; None when there is none, or the scans differ."""
        pitches = {scan.resolution for scan in self.scans}
        return pitches.pop() if len(pitches) == 1 else None

    @property
    def warnings(self) -> Tuple[MapWarning, ...]:
        """The warnings about the present map, and about lines that edits could not change."""
        lines = {id(record): number for number, record in enumerate(self._records, 1)}
        notes = [MapWarning(text, lines[id(record)]) for record, text in self._notes
                 if id(record) in lines]
        return tuple(check(self._records, self._sections, self.scans) + notes)

    def find(self, name: str) -> Optional[MapObject]:
        """Returns the first object with this name, without regard to case, or None."""
        return editing.find(self._records, name)

    def add(self, obj: MapObject) -> None:
        """Adds `obj` at the line of the file at which the vendor's tools would write it.

        Raises DuplicateName, MapError.
        """
        self.add_all([obj])

    def add_all(self, objects: Iterable[MapObject]) -> None:
        """Adds all objects or none; this takes hardly longer than adding one object."""
        editing.add(self.name, self._records, objects)
        self._end_last_row()

    def remove(self, obj: MapObject) -> None:
        """Removes `obj` and its parameter lines; other lines that name it cause warnings."""
        self.remove_all([obj])

    def remove_all(self, objects: Iterable[MapObject]) -> None:
        """Removes all objects or none."""
        self._notes += editing.remove(self.name, self._records, objects)
        self._end_last_row()

    def move(self, obj: MapObject, x: float, y: float, theta: Optional[float] = None) -> None:
        """Moves `obj` to x, y (mm) and theta (degrees; None keeps it).

        - Area: x, y is the new centre.
        - Line: x, y is the new from point; the line is never turned.
        - Goal without heading: theta is ignored.
        """
        editing.move(self.name, self._records, obj, x, y, theta)
        self._end_last_row()

    def rename(self, obj: MapObject, new_name: str) -> None:
        """Renames `obj`, also in routes and parameters that name it.

        Lines that perhaps mean another object stay as they are and cause warnings.
        """
        self._notes += editing.rename(self.name, self._records, obj, new_name)
        self._end_last_row()

    def replace_points(self, points: np.ndarray) -> None:
        """Replaces the points of the scan by `points` (N, 2), whole mm, and updates the header."""
        self._replace_rows('DATA', points)

    def replace_lines(self, lines: np.ndarray) -> None:
        """Replaces the wall lines by `lines` (M, 4), whole mm; the points stay."""
        self._replace_rows('LINES', lines)

    def _replace_rows(self, kind: str, rows: np.ndarray) -> None:
        if [scan.name for scan in self.scans] != ['']:
            raise MapError(self.name, 'only a map of one scan without a name can have its rows '
                           'replaced', field='Sources')
        end = editing.line_end(self._records)
        try:
            rows = scan_editing.checked_rows(rows, kind)
            present = self.points if kind == 'DATA' else self.lines
            if np.array_equal(rows, scan_editing.checked_rows(present, kind)):
                return  # the sequence of the rows in the file has no meaning
            self._sections = scan_editing.with_rows(self._sections, kind, rows, end)
        except FieldError as error:  # a line in this error counts rows, not lines of the file
            raise MapError(self.name, error.problem, None, error.field, error.expected) from None
        scan_editing.update_header(self._records, kind, rows, end)
        self.scans = scans_of(read_headers(self._records, self.name), self._sections)
        self._end_last_row()

    def _end_last_row(self) -> None:
        """Adds a line end to the last row; without it the vendor's library ignores the row."""
        if not self._sections[-1].raw.endswith(b'\n'):
            self._sections[-1] = self._sections[-1].with_final(editing.line_end(self._records))


def _all(blocks: List[np.ndarray]) -> np.ndarray:
    return blocks[0] if len(blocks) == 1 else np.concatenate(blocks)
