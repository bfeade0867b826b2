"""Reads the points of a PointCloud2, in any valid layout."""
from __future__ import annotations

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField

MAX_POINTS = 100_000


def places_in(cloud: PointCloud2) -> np.ndarray:
    """Returns x and y (N, 2) of the points in the cloud's frame (m), without points that are not
    finite.

    Raises ValueError with a clause for a person: the cloud does not have the layout that it
    declares, has no float32 x and y, or has more than MAX_POINTS points.
    """
    count = cloud.width * cloud.height
    if count > MAX_POINTS:
        raise ValueError(f'it has {count} points, but at most {MAX_POINTS} are accepted')
    offsets = {field.name: field.offset for field in cloud.fields
               if field.datatype == PointField.FLOAT32}
    if not {'x', 'y'} <= set(offsets):
        raise ValueError('it has no x and y of type float32')
    last = max(offsets['x'], offsets['y']) + 4
    if last > cloud.point_step or count * cloud.point_step > len(cloud.data) or (
            cloud.height > 1 and cloud.row_step != cloud.width * cloud.point_step):
        raise ValueError('its data do not have the layout that it declares')
    order = '>f4' if cloud.is_bigendian else '<f4'
    layout = np.dtype({'names': ['x', 'y'], 'formats': [order, order],
                       'offsets': [offsets['x'], offsets['y']], 'itemsize': cloud.point_step})
    points = np.frombuffer(cloud.data, layout, count)
    places = np.column_stack((points['x'], points['y'])).astype(float)
    return places[np.isfinite(places).all(axis=1)]
