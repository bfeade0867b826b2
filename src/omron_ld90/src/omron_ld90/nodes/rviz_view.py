"""Opens RViz with the whole map in view, for each map and screen.

    rviz_view MAP_FILE CONFIGURATION [more arguments of rviz]

If the map fits the view of the configuration, and the window fits the screen, RViz gets the
configuration unchanged. Otherwise it gets a copy with another scale and centre of the view, and
another size of the window. A view that is not from above is not changed. A view that cannot be read
is not changed either, and this is reported. On a computer that draws without a graphics card,
anti-aliasing is turned off, because it would take more time than all other drawing. This program is
not a ROS node: its process becomes RViz.
"""
from __future__ import annotations

import ctypes
import glob
import math
import os
import sys
import tempfile
from typing import Any, Dict, List, NamedTuple, Optional

import yaml

from omron_ld90.units import MM_PER_M
from omron_map import MapDocument, MapError, bounds_of

WIDTH, HEIGHT = 1248, 808  # pixels of the 3D view in the configuration's window
FRAME = (32, 92)  # pixels of the window around the view: bars and tools
DESKTOP = 60  # pixels for the title and the bars of the desktop if the screen is too small
BANNER = 1.2  # m above the map for the robot's banner
BORDER = 0.5  # m around the map and the banner
FROM_ABOVE = 'rviz/TopDownOrtho'


class PixelSize(NamedTuple):
    """Width and height in pixels."""

    width: int
    height: int


FULL = PixelSize(WIDTH, HEIGHT)


class View(NamedTuple):
    """A view from above: pixels per metre, and the position (m) in the centre."""

    scale: float
    x: float
    y: float

    @classmethod
    def on(cls, west: float, south: float, east: float, north: float,
           size: PixelSize = FULL) -> View:
        """Returns the view that shows this rectangle (m) as large as possible."""
        scale = min(size.width / (east - west), size.height / (north - south))
        return cls(scale, (west + east) / 2, (south + north) / 2)

    def shows(self, west: float, south: float, east: float, north: float,
              size: PixelSize = FULL) -> bool:
        """Returns whether the whole rectangle (m) is in view."""
        half_width, half_height = size.width / self.scale / 2, size.height / self.scale / 2
        return (west >= self.x - half_width and east <= self.x + half_width
                and south >= self.y - half_height and north <= self.y + half_height)


class CannotFit(Exception):
    """The view of an RViz configuration cannot be fitted to a map; the text is a clause."""


class RvizConfiguration:
    """An RViz configuration: its view from above, and the size of its window."""

    def __init__(self, text: str) -> None:
        """Raises CannotFit if the text is not a configuration with a view."""
        try:
            self._root = yaml.safe_load(text)
            self._view: Dict[str, Any] = self._root['Visualization Manager']['Views']['Current']
            self.is_from_above = self._view.get('Class') == FROM_ABOVE
        except yaml.YAMLError:
            raise CannotFit('it is not YAML') from None
        except (KeyError, TypeError, AttributeError):
            raise CannotFit('it has no current view') from None

    @property
    def view(self) -> View:
        """The view from above; raises CannotFit if one of its values is not a number."""
        try:
            view = View(*(float(self._view[name]) for name in ('Scale', 'X', 'Y')))
        except (KeyError, TypeError, ValueError):
            view = View(math.nan, 0.0, 0.0)
        if not (view.scale > 0.0 and math.isfinite(sum(view))):
            raise CannotFit('its view from above has no Scale, X and Y')
        return view

    @view.setter
    def view(self, view: View) -> None:
        self._view.update(zip(('Scale', 'X', 'Y'), (round(value, 3) for value in view)))

    def fit_window(self, size: PixelSize) -> bool:
        """Shrinks the window until its view has this size. Returns False if it was small enough."""
        window = self._root.get('Window Geometry')
        narrow = {name: pixels + frame for name, pixels, full, frame
                  in zip(('Width', 'Height'), size, FULL, FRAME) if pixels < full}
        if isinstance(window, dict):
            window.update(narrow)
        return bool(narrow)

    def text(self) -> str:
        """Returns the configuration in the format of RViz."""
        return yaml.safe_dump(self._root, sort_keys=False, allow_unicode=True, width=math.inf)


def view_size(screen: PixelSize) -> PixelSize:
    """Returns the size of the 3D view when the configuration's window is fitted to the screen."""
    rest = PixelSize(screen.width, screen.height - DESKTOP)
    return PixelSize(*(size if size + frame <= whole else max(left - frame, 1)
                       for size, frame, whole, left in zip(FULL, FRAME, screen, rest)))


def configuration_for(document: MapDocument, text: str, size: PixelSize = FULL) -> Optional[str]:
    """Returns the RViz configuration `text` with a view of this size that shows the whole map.

    None: `text` shows the whole map already, or its view is not from above. Raises CannotFit.
    """
    configuration = RvizConfiguration(text)
    bounds = bounds_of(document.points, document.lines)
    if bounds is None or not configuration.is_from_above:
        return None
    west, south, east, north = (float(at) / MM_PER_M for corner in bounds for at in corner)
    north += BANNER
    changed = configuration.fit_window(size)
    if not configuration.view.shows(west, south, east, north, size):
        configuration.view = View.on(
            west - BORDER, south - BORDER, east + BORDER, north + BORDER, size)
        changed = True
    return configuration.text() if changed else None


def rendering_arguments() -> List[str]:
    """Returns the arguments that RViz needs to draw fast enough on this computer."""
    software = (os.environ.get('LIBGL_ALWAYS_SOFTWARE', '') not in ('', '0', 'false')
                or not (glob.glob('/dev/dri/*') or glob.glob('/dev/nvidia[0-9]*')))
    return ['--disable-anti-aliasing'] if software else []


def screen_size() -> PixelSize:
    """Returns the size of the screen.

    Without a screen, ends the program with a clear message, which Qt would not give. This function
    uses libX11 as RViz does, so both find the same display. python3-xlib would be a further
    package, and it reads XAUTHORITY in its own way.
    """
    library = ctypes.CDLL('libX11.so.6')
    library.XOpenDisplay.restype = ctypes.c_void_p
    screen = library.XOpenDisplay(None)
    if not screen:
        display = os.environ.get('DISPLAY', '')
        sys.exit(f'RViz is not opened: there is no X display "{display}". Set DISPLAY, or open '
                 'RViz on another computer; everything else runs without it.')
    screen = ctypes.c_void_p(screen)
    size = PixelSize(library.XDisplayWidth(screen, 0), library.XDisplayHeight(screen, 0))
    library.XCloseDisplay(screen)
    return size


def fitted_copy(map_file: str, path: str, size: PixelSize) -> str:
    """Returns the path of a copy of the configuration `path` that shows the whole map.

    Returns `path` itself if no copy is needed, or if the view cannot be fitted. In the second case
    the reason is written to standard error.
    """
    try:
        with open(path, encoding='utf-8') as file:
            fitted = configuration_for(MapDocument.load(map_file), file.read(), size)
    except (OSError, UnicodeDecodeError) as error:
        sys.exit(f'RViz is not opened: its configuration {path} cannot be read ({error}).')
    except CannotFit as error:
        print(f'RViz opens with the view of {path}, not fitted to the map: {error}.',
              file=sys.stderr)
        return path
    except MapError as error:
        print(f'RViz opens with the view of {path}, because the map cannot be used: {error}',
              file=sys.stderr)
        return path
    if fitted is None:
        return path
    copy = os.path.join(tempfile.mkdtemp(prefix='rviz_view_'), os.path.basename(path))
    with open(copy, 'w', encoding='utf-8') as file:
        file.write(fitted)
    return copy


def main() -> None:
    """Replaces this process with RViz."""
    if len(sys.argv) < 3:
        sys.exit('usage: rviz_view MAP_FILE CONFIGURATION [more arguments of rviz]')
    map_file, path, *arguments = sys.argv[1:]
    path = fitted_copy(map_file, path, view_size(screen_size()))
    os.execvp('rviz', ['rviz', '-d', path, *rendering_arguments(), *arguments])
