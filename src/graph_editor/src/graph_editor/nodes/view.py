"""Opens RViz with a view of the whole map. This program is not a ROS node; RViz replaces its
process.

    graph_editor_view MAP_FILE CONFIGURATION [more arguments of rviz]
"""
from __future__ import annotations

import glob
import os
import re
import sys
import tempfile
from typing import Tuple

import numpy as np

from graph_editor.floor import Floor
from graph_editor.make_cli import ERRORS
from graph_editor.nodes.live_map import load_map
from graph_editor.site import SiteOptions

WIDTH, HEIGHT = 1248, 808  # px, the 3D view in the window of the configuration
BORDER = 0.8  # m; margin around the map
WORDS_ABOVE = 1.2  # m; space above the map for the message


def fitted(text: str, floor: Floor) -> str:
    """Returns the RViz configuration `text` with a view that shows the whole floor."""
    (west, south), (east, north) = _bounds(floor)
    north += WORDS_ABOVE
    scale = min(WIDTH / (east - west + 2.0 * BORDER), HEIGHT / (north - south + 2.0 * BORDER))
    values = {'Scale': scale, 'X': (west + east) / 2.0, 'Y': (south + north) / 2.0}
    head, views, tail = text.partition('\n  Views:\n    Current:\n')
    for name, value in values.items():
        tail = re.sub(rf'(?m)^      {name}: \S+$', f'      {name}: {value:.3f}', tail, count=1)
    return head + views + tail


def _bounds(floor: Floor) -> Tuple[np.ndarray, np.ndarray]:
    rows, columns = np.nonzero(floor.inside | floor.occupied)
    places = floor.centres(rows, columns)
    return places.min(axis=0), places.max(axis=0)


def rendering_arguments() -> Tuple[str, ...]:
    """Returns arguments that disable anti-aliasing, which is slow without a graphics card."""
    software = (os.environ.get('LIBGL_ALWAYS_SOFTWARE', '') not in ('', '0', 'false')
                or not (glob.glob('/dev/dri/*') or glob.glob('/dev/nvidia[0-9]*')))
    return ('--disable-anti-aliasing',) if software else ()


def main() -> None:
    """Replaces this process by RViz."""
    map_file, path, *arguments = sys.argv[1:]
    try:
        with open(path, encoding='utf-8') as stream:
            text = fitted(stream.read(), load_map(map_file, SiteOptions()).floor)
        path = os.path.join(tempfile.mkdtemp(prefix='graph_editor_view_'), os.path.basename(path))
        with open(path, 'w', encoding='utf-8') as stream:
            stream.write(text)
    except ERRORS as error:
        print(f'The view {path} cannot be fitted to the map ({error}). RViz opens with this view '
              'unchanged.', file=sys.stderr)
    os.execvp('rviz', ['rviz', '-d', path, *rendering_arguments(), *arguments])
