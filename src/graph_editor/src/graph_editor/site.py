"""Reads sites, i.e. a floor and its places, from a robot's `.map`, a ROS map, or an occupancy grid.

This is the only module that uses `.map` files. Its results are in metres and radians.
"""
from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from enum import Enum
from typing import Optional, Tuple

import numpy as np

from graph_editor.errors import SiteError
from graph_editor.floor import LARGEST_GRID, Floor, inside_outline
from graph_editor.ros_map import load_ros_map
from omron_map import OCCUPIED, MapDocument, OccupancyGrid

CONVERTERS_FENCE = 'omron_ros_map fence'
"""The description of areas and lines that a converter has added around a graph's corridors."""


class PlaceKind(Enum):
    """The use of a place of the map."""

    GOAL = 'goal'
    DOCK = 'dock'
    HOME = 'home'
    """A place at which robots may be switched on. The reachable floor is computed from homes; a
    home gets no vertex.
    """


@dataclass(frozen=True)
class NamedPlace:
    """A place with a name. `heading` is in rad; None: any heading is allowed."""

    kind: PlaceKind
    name: str
    x: float
    y: float
    heading: Optional[float] = None

    @property
    def position(self) -> Tuple[float, float]:
        """The position x, y, in m."""
        return self.x, self.y


@dataclass(frozen=True, eq=False)
class MappedSite:
    """A floor with its known places."""

    name: str
    """The file or the name of the map."""
    floor: Floor
    places: Tuple[NamedPlace, ...] = ()
    notes: Tuple[str, ...] = ()
    """Warnings about the map for people, one sentence each."""

    @property
    def frame_id(self) -> str:
        """The FrameId for the vertices of a graph on this map."""
        return f'map/{os.path.splitext(os.path.basename(self.name))[0]}'


@dataclass(frozen=True)
class SiteOptions:
    """The part of a map that is used, and the size of the cells (m)."""

    area: Optional[Tuple[float, float, float, float]] = None
    """x1, y1, x2, y2, m: the part that is used; None: the part inside the scanned outline."""
    outline_gap: float = 3.0
    """m; gaps in the scanned outline up to this width are closed."""
    resolution: float = 0.05


def load_site(path: str, options: SiteOptions) -> MappedSite:
    """Returns the site of a `.map` file or of the `.yaml` of a ROS map.

    Raises SiteError or MapError.
    """
    if os.path.splitext(path)[1].lower() in ('.yaml', '.yml'):
        grid = load_ros_map(path)
        site = site_of_grid(grid.cells, grid.resolution, grid.origin, options, path)
        return replace(site, notes=(*site.notes, *grid.notes))
    return site_of_document(MapDocument.load(path), options)


def site_of_document(document: MapDocument, options: SiteOptions) -> MappedSite:
    """Returns the site of a robot's map.

    Scan points, lines, forbidden areas and forbidden lines are obstacles.
    """
    pitch = max(1, round(options.resolution * 1000.0))
    grid = OccupancyGrid.from_map(document, pitch, 'both', areas=True)
    occupied = grid.cells == OCCUPIED
    origin = (grid.origin[0] / 1000.0, grid.origin[1] / 1000.0)
    inside = _inside(occupied, pitch / 1000.0, origin, options)
    notes = []
    if any(obj.description == CONVERTERS_FENCE
           for obj in document.forbidden_areas + document.forbidden_lines):
        notes.append(f'{document.name} already contains the fences and goals of a graph: use the '
                     'original map without them.')
    floor = Floor(occupied, inside, pitch / 1000.0, origin, _obstacles(document, pitch))
    return MappedSite(document.name, floor, _places(document), tuple(notes))


def _obstacles(document: MapDocument, pitch: float) -> np.ndarray:
    """Returns points of obstacles (N,2; m): scan points, and points on lines and on the outlines of
    areas.

    pitch -- largest distance between two points on a line, mm
    """
    sides = [np.hstack((corners, np.roll(corners, -1, axis=0))) for corners in (
        np.asarray(area.rectangle.corners, float) for area in document.forbidden_areas)]
    lines = [line.ends.reshape(1, 4) for line in document.forbidden_lines]
    segments = np.vstack([np.asarray(document.lines, float).reshape(-1, 4), *lines, *sides])
    starts, ends = segments[:, :2], segments[:, 2:]
    points = [np.asarray(document.points, float).reshape(-1, 2)]
    for start, end in zip(starts, ends):
        count = int(np.hypot(*(end - start)) / pitch) + 2
        points.append(start + np.linspace(0.0, 1.0, count)[:, None] * (end - start))
    return np.vstack(points) / 1000.0


def site_of_grid(cells: np.ndarray, resolution: float, origin: Tuple[float, float],
                 options: SiteOptions, name: str = 'map') -> MappedSite:
    """Returns the site of an occupancy grid (rows from the lowest y; 0..100, -1 unknown), in m.

    Unknown cells are not floor. If a grid has only obstacles and no free cells, its floor is the
    area inside the outline of the obstacles.
    """
    if cells.size > LARGEST_GRID:
        raise SiteError(f'{name} has {cells.size} cells, but {LARGEST_GRID} is the most.')
    occupied = cells >= 50
    known = (cells >= 0) & ~occupied
    inside = _inside(occupied, resolution, origin, options)
    if known.any():
        inside = known & inside if options.area is not None else known
    return MappedSite(name, Floor(occupied, inside, resolution, origin))


def _inside(occupied: np.ndarray, resolution: float, origin: Tuple[float, float],
            options: SiteOptions) -> np.ndarray:
    if options.area is None:
        return inside_outline(occupied, resolution, options.outline_gap)
    x1, y1, x2, y2 = options.area
    rows, columns = occupied.shape
    xs = origin[0] + (np.arange(columns) + 0.5) * resolution
    ys = origin[1] + (np.arange(rows) + 0.5) * resolution
    return (((ys >= min(y1, y2)) & (ys <= max(y1, y2)))[:, None]
            & ((xs >= min(x1, x2)) & (xs <= max(x1, x2)))[None, :])


def _places(document: MapDocument) -> Tuple[NamedPlace, ...]:
    places = []
    for kind, objects in ((PlaceKind.DOCK, document.docks), (PlaceKind.GOAL, document.goals),
                          (PlaceKind.HOME, document.homes)):
        for obj in objects:
            x, y = obj.x, obj.y
            if obj.is_area:
                x, y = obj.rectangle.centre_x, obj.rectangle.centre_y
            heading = math.radians(obj.theta) if obj.has_heading else None
            places.append(NamedPlace(kind, obj.label, x / 1000.0, y / 1000.0, heading))
    return tuple(places)
