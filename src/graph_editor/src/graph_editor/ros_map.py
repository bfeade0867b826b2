"""Reads ROS maps, i.e. the `.yaml` file and the image of `map_server`, as occupancy grids.

The value of a pixel is computed as in map_server (image_loader.cpp, mode trinary): as the mean of
all its channels, alpha included. map_server reads images with SDL_image. SDL_image takes the high
byte of 16-bit PNG files, and refuses 16-bit PGM files. For an image with a palette it gives the
index of a colour instead of the colour. So this module refuses images for which its values could
differ from those of map_server.
"""
from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Iterator, Tuple

import numpy as np
from PIL import Image

from graph_editor.errors import SiteError
from graph_editor.floor import LARGEST_GRID
from trajectory_graph import strict_yaml
from trajectory_graph.strict_yaml import WrongYaml

UNKNOWN = 205  # grey value of unknown cells in images of map_saver
_MODES = ('1', 'L', 'LA', 'RGB', 'RGBA', 'I', 'I;16', 'I;16B')  # modes of Pillow
_KEYS = ('image', 'resolution', 'origin', 'occupied_thresh', 'free_thresh', 'negate', 'mode')


@dataclass(frozen=True, eq=False)
class RosMap:
    """An occupancy grid, as map_server makes it from a file.

    cells  -- (rows, columns) int8: 0 free, 100 occupied, -1 unknown; row 0 has the lowest y
    origin -- x, y in m of the lower left corner
    notes  -- warnings for people, one sentence each
    """

    cells: np.ndarray
    resolution: float
    origin: Tuple[float, float]
    notes: Tuple[str, ...] = ()


@dataclass(frozen=True)
class _Description:
    """The contents of the `.yaml` file; thresholds are shares of black, 0..1."""

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
    if not 0.0 <= description.free_to < description.occupied_from <= 1.0:
        raise SiteError(
            f'{path}: free_thresh is {description.free_to:g} and occupied_thresh '
            f'{description.occupied_from:g}, but they are shares of black from 0 to 1, not '
            'percent, and free_thresh is the smaller one; map_saver writes 0.196 and 0.65.')
    grey = _values(os.path.join(os.path.dirname(path), description.image), path)
    darkness = grey / 255.0 if description.inverted else 1.0 - grey / 255.0
    cells = np.full(grey.shape, -1, np.int8)
    cells[darkness < description.free_to] = 0
    cells[darkness > description.occupied_from] = 100
    return RosMap(cells, description.resolution, (x, y),
                  tuple(_notes(path, description, grey, cells)))


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


def _notes(path: str, description: _Description, grey: np.ndarray,
           cells: np.ndarray) -> Iterator[str]:
    unknown = 1.0 - UNKNOWN / 255.0
    if not description.inverted and description.free_to > unknown and (grey == UNKNOWN).any():
        yield (f'{path}: free_thresh is {description.free_to:g}, so the grey {UNKNOWN}, which '
               f'map_saver writes for unknown cells, is free floor; if it shall be unknown, write '
               'free_thresh: 0.196.')
    if not (cells == 100).any():
        yield (f'{path}: no cell is occupied, so this map has no walls: check the thresholds and '
               'negate.')


def _values(image_path: str, path: str) -> np.ndarray:
    """Returns the values of the pixels (rows, columns), 0..255, with the bottom row first."""
    try:
        with Image.open(image_path) as image:
            columns, rows = image.size
            if rows * columns > LARGEST_GRID:
                raise SiteError(f'{image_path}, the image of {path}, has {rows * columns} pixels, '
                                f'but {LARGEST_GRID} is the most.')
            return _as_map_server(image, image_path, path)[::-1]
    except (OSError, ValueError, Image.DecompressionBombError) as error:
        raise SiteError(f'{image_path}, the image of {path}, cannot be read ({error}).') from None


def _as_map_server(image: Image.Image, image_path: str, path: str) -> np.ndarray:
    """Returns the mean of the channels of each pixel, as map_server computes it, 0..255."""
    if 'transparency' in image.info or image.mode not in _MODES or (
            image.mode.startswith('I') and image.format != 'PNG'):
        raise SiteError(f'{image_path}, the image of {path}, is of a kind that map_server reads '
                        f'otherwise or not at all ({image.format}, {image.mode}): save it as an '
                        '8-bit grey PGM or PNG file.')
    if image.mode.startswith('I'):
        return np.floor_divide(np.asarray(image, np.int32), 256).astype(float)
    if image.mode in ('1', 'L'):
        return np.asarray(image.convert('L'), float)
    channels = np.asarray(image.convert('RGBA') if image.mode == 'LA' else image, float)
    return channels.mean(axis=2)
