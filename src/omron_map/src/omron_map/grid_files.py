"""Writes occupancy grids as the two files that `map_server` and other robots load: image and YAML.

The grey values are those of `map_saver`. The top row of the image has the highest y.
"""
from __future__ import annotations

import io
import os
from typing import Tuple

import numpy as np
import yaml
from PIL import Image

from omron_map.errors import MapError
from omron_map.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from omron_map.saving import MADE_BY, png_notes, write_file

#: Grey value of each kind of cell. (255 - 205) / 255 is slightly above FREE_THRESHOLD: not free.
GREY = {FREE: 254, UNKNOWN: 205, OCCUPIED: 0}
OCCUPIED_THRESHOLD, FREE_THRESHOLD = 0.65, 0.196
FORMATS = ('.png', '.pgm')


def export_grid(grid: OccupancyGrid, path: str, is_named: bool = True) -> Tuple[str, str]:
    """Writes `grid` to `path` (.png, .pgm, or the .yaml of a .pgm).

    Returns the paths of the image and of the YAML file in the same folder. The YAML file names the
    image relative to itself. Each file is replaced in one step. A file whose name the user did not
    give is replaced only if ld_map has written it. Such a file is written first: if this is
    refused, nothing has changed. Raises MapError.

    is_named -- whether the user gave `path`
    """
    stem, suffix = os.path.splitext(path)
    if suffix in ('', '.yaml'):
        suffix = '.pgm'
    if suffix.lower() not in FORMATS:
        raise MapError(path, f'an image of type {suffix!r} cannot be written',
                       expected=' or '.join(FORMATS))
    image_path, yaml_path = stem + suffix, stem + '.yaml'
    shades = np.full(256, GREY[UNKNOWN], np.uint8)
    for cell, grey in GREY.items():
        shades[cell] = grey
    image = Image.fromarray(shades[grid.cells[::-1].view(np.uint8)])
    buffer = io.BytesIO()
    if suffix.lower() == '.png':
        image.save(buffer, 'PNG', pnginfo=png_notes())
    else:
        buffer.write(f'P5\n# {MADE_BY}\n{image.width} {image.height}\n255\n'.encode())
        buffer.write(image.tobytes())
    description = _description(grid, os.path.basename(image_path))
    named = path if is_named else ''
    files = [(image_path, buffer.getvalue()), (yaml_path, description)]
    for file, data in sorted(files, key=lambda one: one[0] == named):
        write_file(file, data, is_named=file == named)
    return image_path, yaml_path


def _description(grid: OccupancyGrid, image: str) -> bytes:
    content = {
        'image': image,
        'resolution': grid.resolution / 1000.0,
        'origin': [grid.origin[0] / 1000.0, grid.origin[1] / 1000.0, 0.0],
        'negate': 0,
        'occupied_thresh': OCCUPIED_THRESHOLD,
        'free_thresh': FREE_THRESHOLD,
    }
    text = yaml.safe_dump(content, sort_keys=False, allow_unicode=True)
    return f'# {MADE_BY}\n{text}'.encode()
