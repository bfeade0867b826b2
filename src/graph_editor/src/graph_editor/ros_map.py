"""Reads ROS maps, i.e. the `.yaml` file and the image of `map_server`, as occupancy grids."""
from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Tuple

import numpy as np
from PIL import Image

from graph_editor.errors import SiteError
from graph_editor.floor import LARGEST_GRID
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import WrongYaml

_KEYS = ('image', 'resolution', 'origin', 'occupied_thresh', 'free_thresh', 'negate', 'mode')


@dataclass(frozen=True, eq=False)
class RosMap:
    """An occupancy grid, as map_server makes it from a file.

    cells  -- (rows, columns) int8: 0 free, 100 occupied, -1 unknown; row 0 has the lowest y
    origin -- x, y in m of the lower left corner
    """

    cells: np.ndarray
    resolution: float
    origin: Tuple[float, float]


@dataclass(frozen=True)
class _Description:
    """The contents of the `.yaml` file; thresholds are darkness, 0..1."""

    image: str
    resolution: float
    origin: Tuple[float, ...]
    occupied_from: float
    free_to: float
    inverted: bool
    mode: str


def load_ros_map(path: str) -> RosMap:
    """Returns the map that the `.yaml` file `path` describes; raises SiteError."""
    try:
        description = _described(path)
    except WrongYaml as wrong:
        where = '' if wrong.line is None else f', line {wrong.line}'
        raise SiteError(f'{path}{where}: {wrong.problem}; a ROS map needs image, resolution, '
                        'origin, occupied_thresh and free_thresh.') from None
    x, y, yaw = description.origin
    if not 0.0 < description.resolution < math.inf or not abs(x) + abs(y) < math.inf:
        raise SiteError(f'{path}: resolution is {description.resolution:g}, origin {x:g}, {y:g}, '
                        'but both must be numbers, and the resolution positive.')
    if yaw != 0.0 or description.mode != 'trinary':
        raise SiteError(f'{path}: yaw is {yaw:g} and mode {description.mode}, but only maps with '
                        'yaw 0 and mode trinary can be used.')
    grey = _grey(os.path.join(os.path.dirname(path), description.image), path)
    darkness = grey / 255.0 if description.inverted else 1.0 - grey / 255.0
    cells = np.full(grey.shape, -1, np.int8)
    cells[darkness < description.free_to] = 0
    cells[darkness > description.occupied_from] = 100
    return RosMap(cells, description.resolution, (x, y))


def _described(path: str) -> _Description:
    root = strict_yaml.compose(path)
    fields = strict_yaml.mapping(root, 'the file', _KEYS)
    origin = strict_yaml.field(fields, 'origin', root)
    numbers = strict_yaml.listed(strict_yaml.real)(origin)
    if len(numbers) != 3:
        raise WrongYaml('origin must be x, y and yaw', origin[1])
    return _Description(
        image=strict_yaml.text(strict_yaml.field(fields, 'image', root)),
        resolution=strict_yaml.real(strict_yaml.field(fields, 'resolution', root)),
        origin=tuple(numbers),
        occupied_from=strict_yaml.real(strict_yaml.field(fields, 'occupied_thresh', root)),
        free_to=strict_yaml.real(strict_yaml.field(fields, 'free_thresh', root)),
        inverted=bool(strict_yaml.optional(fields, 'negate', strict_yaml.whole, 0)),
        mode=strict_yaml.optional(fields, 'mode', strict_yaml.text, 'trinary'))


def _grey(image_path: str, path: str) -> np.ndarray:
    """Returns the grey values (rows, columns), 0..255, with the lowest row first."""
    try:
        with Image.open(image_path) as image:
            columns, rows = image.size
            if rows * columns > LARGEST_GRID:
                raise SiteError(f'{image_path}, the image of {path}, has {rows * columns} pixels, '
                                f'but {LARGEST_GRID} is the most.')
            return np.asarray(image.convert('L'), float)[::-1]
    except (OSError, ValueError, Image.DecompressionBombError) as error:
        raise SiteError(f'{image_path}, the image of {path}, cannot be read ({error}).') from None
