"""Opens RViz with the whole map in view, whatever the map: a configuration's view fits one only.

    rviz_view MAP_FILE CONFIGURATION [more arguments of rviz]

Where the map fits the view of the configuration, RViz gets that file as it is; else a copy in which
the view's scale and middle are changed. Where a program draws instead of a graphics card, RViz is
told to leave out anti-aliasing, which then costs more than all the rest. No ROS node: it becomes
RViz.
"""
from __future__ import annotations

import ctypes
import glob
import os
import re
import sys
import tempfile
from typing import List, NamedTuple, Optional

import numpy as np

from omron_ld90.maps import MapDocument, MapError
from omron_ld90.nodes.units import MM_PER_M

WIDTH, HEIGHT = 1248, 808  # pixels of the 3D view in the configuration's window
WORDS_ABOVE = 1.2  # m above the map for the robot's words
BORDER = 0.5  # m around it all


class View(NamedTuple):
    """What is seen from above: pixels per metre, and the place (m) in the middle."""

    scale: float
    x: float
    y: float

    @classmethod
    def in_configuration(cls, text: str) -> View:
        """The view that an RViz configuration opens with."""
        return cls(*(float(_line(name).search(_current(text))[1]) for name in ('Scale', 'X', 'Y')))

    @classmethod
    def on(cls, west: float, south: float, east: float, north: float) -> View:
        """The view that shows this rectangle (m) as large as it can be."""
        scale = min(WIDTH / (east - west), HEIGHT / (north - south))
        return cls(scale, (west + east) / 2, (south + north) / 2)

    def shows(self, west: float, south: float, east: float, north: float) -> bool:
        """Is the whole rectangle (m) in view?"""
        half_width, half_height = WIDTH / self.scale / 2, HEIGHT / self.scale / 2
        return (west >= self.x - half_width and east <= self.x + half_width
                and south >= self.y - half_height and north <= self.y + half_height)

    def put_into(self, text: str) -> str:
        """The RViz configuration `text` with this view."""
        view = _current(text)
        changed = view
        for name, value in zip(('Scale', 'X', 'Y'), self):
            changed = _line(name).sub(f'      {name}: {value:.3f}', changed, count=1)
        return text.replace(view, changed)


def configuration_for(document: MapDocument, text: str) -> Optional[str]:
    """The RViz configuration `text` with a view that shows all of the map; None if it does so."""
    places = np.concatenate([document.points, document.lines.reshape(-1, 2)]) / MM_PER_M
    if not len(places):
        return None
    (west, south), (east, north) = places.min(axis=0), places.max(axis=0)
    north += WORDS_ABOVE
    if View.in_configuration(text).shows(west, south, east, north):
        return None
    return View.on(west - BORDER, south - BORDER, east + BORDER, north + BORDER).put_into(text)


def rendering_arguments() -> List[str]:
    """The arguments that RViz needs to draw at a good pace on this computer."""
    software = (os.environ.get('LIBGL_ALWAYS_SOFTWARE', '') not in ('', '0', 'false')
                or not (glob.glob('/dev/dri/*') or glob.glob('/dev/nvidia[0-9]*')))
    return ['--disable-anti-aliasing'] if software else []


def check_display() -> None:
    """Ends the program with a sentence where no window can be opened: Qt speaks in riddles."""
    if not ctypes.CDLL('libX11.so.6').XOpenDisplay(None):
        display = os.environ.get('DISPLAY', '')
        sys.exit(f'RViz is not opened: there is no X display "{display}". Set DISPLAY, or open '
                 'RViz on another computer; everything else runs without it.')


def main() -> None:
    """Become RViz."""
    check_display()
    map_file, path, *arguments = sys.argv[1:]
    try:
        with open(path, encoding='utf-8') as file:
            fitted = configuration_for(MapDocument.load(map_file), file.read())
    except MapError as error:
        print(f'RViz opens with the view of {path}: {error}', file=sys.stderr)
        fitted = None
    if fitted is not None:
        path = os.path.join(tempfile.mkdtemp(prefix='rviz_view_'), os.path.basename(path))
        with open(path, 'w', encoding='utf-8') as file:
            file.write(fitted)
    os.execvp('rviz', ['rviz', '-d', path, *rendering_arguments(), *arguments])


def _current(text: str) -> str:
    return text[text.index('  Views:\n    Current:\n'):]


def _line(name: str) -> re.Pattern:
    return re.compile(rf'(?m)^      {name}: (\S+)$')
