"""Opens RViz with the whole map in view, whatever the map and the screen.

    rviz_view MAP_FILE CONFIGURATION [more arguments of rviz]

Where the map fits the view of the configuration, and its window the screen, RViz gets that file as
it is; else a copy in which the view's scale and middle, and the window's size, are changed. A view
that is not from above is left alone. Where a program draws instead of a graphics card, RViz is told
to leave out anti-aliasing, which then costs more than all the rest. No ROS node: it becomes RViz.
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

from omron_ld90.units import MM_PER_M
from omron_map import MapDocument, MapError

WIDTH, HEIGHT = 1248, 808  # pixels of the 3D view in the configuration's window
FRAME = (32, 92)  # pixels of the window around the view: bars and tools
DESKTOP = 60  # pixels that a title and the desktop's bars take of a screen that is smaller
WORDS_ABOVE = 1.2  # m above the map for the robot's words
BORDER = 0.5  # m around it all


class Size(NamedTuple):
    """Width and height in pixels."""

    width: int
    height: int


FULL = Size(WIDTH, HEIGHT)


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
    def on(cls, west: float, south: float, east: float, north: float, size: Size = FULL) -> View:
        """The view that shows this rectangle (m) as large as it can be."""
        scale = min(size.width / (east - west), size.height / (north - south))
        return cls(scale, (west + east) / 2, (south + north) / 2)

    def shows(self, west: float, south: float, east: float, north: float,
              size: Size = FULL) -> bool:
        """Is the whole rectangle (m) in view?"""
        half_width, half_height = size.width / self.scale / 2, size.height / self.scale / 2
        return (west >= self.x - half_width and east <= self.x + half_width
                and south >= self.y - half_height and north <= self.y + half_height)

    def put_into(self, text: str) -> str:
        """The RViz configuration `text` with this view."""
        view = _current(text)
        changed = view
        for name, value in zip(('Scale', 'X', 'Y'), self):
            changed = _line(name).sub(f'      {name}: {value:.3f}', changed, count=1)
        return text.replace(view, changed)


def view_size(screen: Size) -> Size:
    """The size of the 3D view where the configuration's window is made to fit the screen."""
    rest = Size(screen.width, screen.height - DESKTOP)
    return Size(*(size if size + frame <= whole else max(left - frame, 1)
                  for size, frame, whole, left in zip(FULL, FRAME, screen, rest)))


def configuration_for(document: MapDocument, text: str, size: Size = FULL) -> Optional[str]:
    """The RViz configuration `text` with a view of that size that shows all of the map.

    None if it does so, or if its view is not from above.
    """
    places = np.concatenate([document.points, document.lines.reshape(-1, 2)]) / MM_PER_M
    if not len(places) or 'Class: rviz/TopDownOrtho\n' not in _current(text):
        return None
    (west, south), (east, north) = places.min(axis=0), places.max(axis=0)
    north += WORDS_ABOVE
    fitted = _with_window_around(size, text)
    if not View.in_configuration(text).shows(west, south, east, north, size):
        view = View.on(west - BORDER, south - BORDER, east + BORDER, north + BORDER, size)
        fitted = view.put_into(fitted)
    return None if fitted == text else fitted


def rendering_arguments() -> List[str]:
    """The arguments that RViz needs to draw at a good pace on this computer."""
    software = (os.environ.get('LIBGL_ALWAYS_SOFTWARE', '') not in ('', '0', 'false')
                or not (glob.glob('/dev/dri/*') or glob.glob('/dev/nvidia[0-9]*')))
    return ['--disable-anti-aliasing'] if software else []


def screen_size() -> Size:
    """The screen's; ends the program with a sentence where there is none: Qt speaks in riddles."""
    library = ctypes.CDLL('libX11.so.6')
    library.XOpenDisplay.restype = ctypes.c_void_p
    screen = library.XOpenDisplay(None)
    if not screen:
        display = os.environ.get('DISPLAY', '')
        sys.exit(f'RViz is not opened: there is no X display "{display}". Set DISPLAY, or open '
                 'RViz on another computer; everything else runs without it.')
    screen = ctypes.c_void_p(screen)
    size = Size(library.XDisplayWidth(screen, 0), library.XDisplayHeight(screen, 0))
    library.XCloseDisplay(screen)
    return size


def main() -> None:
    """Become RViz."""
    size = view_size(screen_size())
    map_file, path, *arguments = sys.argv[1:]
    try:
        with open(path, encoding='utf-8') as file:
            fitted = configuration_for(MapDocument.load(map_file), file.read(), size)
    except MapError as error:
        print(f'RViz opens with the view of {path}: {error}', file=sys.stderr)
        fitted = None
    if fitted is not None:
        path = os.path.join(tempfile.mkdtemp(prefix='rviz_view_'), os.path.basename(path))
        with open(path, 'w', encoding='utf-8') as file:
            file.write(fitted)
    os.execvp('rviz', ['rviz', '-d', path, *rendering_arguments(), *arguments])


def _with_window_around(size: Size, text: str) -> str:
    """`text` with a window that is no larger than a view of that size needs."""
    head, title, window = text.rpartition('Window Geometry:\n')
    for name, pixels, full, frame in zip(('Width', 'Height'), size, FULL, FRAME):
        if pixels < full:
            window = re.sub(rf'(?m)^  {name}: \d+$', f'  {name}: {pixels + frame}', window)
    return head + title + window


def _current(text: str) -> str:
    return text[text.index('  Views:\n    Current:\n'):]


def _line(name: str) -> re.Pattern:
    return re.compile(rf'(?m)^      {name}: (\S+)$')
