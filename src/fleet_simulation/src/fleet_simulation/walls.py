"""Reads the walls of a site from a `.map` file, for the map in the report."""
from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Union

import numpy as np

from fleet_simulation.site import WrongSite
from omron_map import MapDocument, MapError, OccupancyGrid
from omron_map.occupancy import OCCUPIED, fitting_resolution

_CELL = 50  # mm


@dataclass(frozen=True, eq=False)
class Walls:
    """The occupied cells of a map.

    centres -- (N,2) m
    cell    -- m, the side of a cell
    """

    centres: np.ndarray
    cell: float


NO_WALLS = Walls(np.zeros((0, 2)), 1.0)


def load_walls(path: Union[str, os.PathLike]) -> Walls:
    """Returns the walls of a `.map` file; raises WrongSite."""
    try:
        document = MapDocument.load(os.fspath(path))
        grid = OccupancyGrid.from_map(document, fitting_resolution(document, _CELL), use='both')
    except MapError as error:
        raise WrongSite(f'The walls cannot be drawn: {error}') from None
    except OSError as error:
        raise WrongSite(f'The walls cannot be drawn: {path}: {error.strerror}.') from None
    rows, columns = np.nonzero(grid.cells == OCCUPIED)
    cells = np.column_stack((columns, rows)) + 0.5
    return Walls((cells * grid.resolution + grid.origin) / 1000.0, grid.resolution / 1000.0)
