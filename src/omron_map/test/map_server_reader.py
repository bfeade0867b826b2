"""Reads an image and its YAML file by the rules of ROS 1 map_server in trinary mode.

From http://wiki.ros.org/map_server: occupancy p = (255 - grey) / 255 (negate 0); a cell is occupied
when p > occupied_thresh, free when p < free_thresh, else unknown. The image path is relative to the
YAML file; the origin is the lower left corner of the lower left pixel.
"""
from __future__ import annotations

import os
from typing import NamedTuple, Tuple

import numpy as np
import yaml
from PIL import Image


class ServedMap(NamedTuple):
    """A grid as map_server publishes it, in metres. Row 0 is at the lowest y."""

    cells: np.ndarray
    resolution: float
    origin: Tuple[float, float, float]


def read_served_map(path: str) -> ServedMap:
    with open(path, encoding='utf-8') as file:
        description = yaml.safe_load(file)
    assert description['negate'] in (0, 1)
    image = Image.open(os.path.join(os.path.dirname(path), description['image']))
    assert image.mode == 'L', 'one grey channel'
    grey = np.asarray(image, float)
    occupancy = (grey if description['negate'] else 255.0 - grey) / 255.0
    cells = np.full(grey.shape, -1, np.int8)
    cells[occupancy > description['occupied_thresh']] = 100
    cells[occupancy < description['free_thresh']] = 0
    return ServedMap(cells[::-1], float(description['resolution']), tuple(description['origin']))
