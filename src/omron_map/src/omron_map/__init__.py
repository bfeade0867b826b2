"""Reads, edits and writes the `.map` files of OMRON mobile robots without loss, and makes grids.

Lengths are in millimetres and angles in degrees, as in the files. The package does not use ROS.
Further modules, which are separate because they load more libraries than reading a map needs:
- `omron_map.picture` draws maps
- `omron_map.grid_files` writes grids for map_server
- `omron_map.compare` finds the differences between two maps
- `omron_map.reach` finds places of a map that are cut off
"""
from omron_map.document import MapDocument
from omron_map.errors import DuplicateName, MapError, MapWarning
from omron_map.geometry import Extent, RotatedRectangle, bounds_of
from omron_map.objects import MapObject
from omron_map.occupancy import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    OccupancyGrid,
    fitting_resolution,
)
from omron_map.scans import Scan
from omron_map.text import printable, printable_path
from omron_map.watch import MapWatcher, wait_for_map

__all__ = [
    'DuplicateName', 'Extent', 'FREE', 'MapDocument', 'MapError', 'MapObject', 'MapWarning',
    'MapWatcher', 'OCCUPIED', 'OccupancyGrid', 'RotatedRectangle', 'Scan', 'UNKNOWN', 'bounds_of',
    'fitting_resolution', 'printable', 'printable_path', 'wait_for_map',
]
