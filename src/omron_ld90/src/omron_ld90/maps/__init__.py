"""`.map` files of the LD-90: documents, occupancy grids, pictures. No ROS; mm and degrees."""
from omron_ld90.maps.document import MapDocument
from omron_ld90.maps.errors import DuplicateName, MapError, MapWarning
from omron_ld90.maps.geometry import Extent, RotatedRectangle
from omron_ld90.maps.objects import MapObject
from omron_ld90.maps.occupancy import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    OccupancyGrid,
    fitting_resolution,
)
from omron_ld90.maps.scans import Scan
from omron_ld90.maps.watch import MapWatcher, wait_for_map

__all__ = [
    'DuplicateName', 'Extent', 'FREE', 'MapDocument', 'MapError', 'MapObject', 'MapWarning',
    'MapWatcher', 'OCCUPIED', 'OccupancyGrid', 'RotatedRectangle', 'Scan', 'UNKNOWN',
    'fitting_resolution', 'wait_for_map',
]
