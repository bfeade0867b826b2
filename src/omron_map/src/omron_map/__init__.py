"""`.map` files of the LD-90: documents, occupancy grids, pictures. No ROS; mm and degrees."""
from omron_map.document import MapDocument
from omron_map.errors import DuplicateName, MapError, MapWarning
from omron_map.geometry import Extent, RotatedRectangle
from omron_map.objects import MapObject
from omron_map.occupancy import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    OccupancyGrid,
    fitting_resolution,
)
from omron_map.scans import Scan
from omron_map.watch import MapWatcher, wait_for_map

__all__ = [
    'DuplicateName', 'Extent', 'FREE', 'MapDocument', 'MapError', 'MapObject', 'MapWarning',
    'MapWatcher', 'OCCUPIED', 'OccupancyGrid', 'RotatedRectangle', 'Scan', 'UNKNOWN',
    'fitting_resolution', 'wait_for_map',
]
