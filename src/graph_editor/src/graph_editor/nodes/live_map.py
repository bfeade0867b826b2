"""Loads maps from files, or for `topic:NAME` from an occupancy grid on a topic.

ROS is imported only for a topic, because files do not need a ROS master.
"""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graph_editor.errors import SiteError
from graph_editor.site import MappedSite, SiteOptions, load_site, site_of_grid

if TYPE_CHECKING:
    from nav_msgs.msg import OccupancyGrid

TOPIC = 'topic:'
PATIENCE = 10.0  # s; longest wait for a map


def load_map(name: str, options: SiteOptions) -> MappedSite:
    """Returns the site of a map file, or of the map on a topic (`topic:NAME`). Raises SiteError,
    MapError.
    """
    if not name.startswith(TOPIC):
        return load_site(name, options)
    return site_of_message(_received(name[len(TOPIC):]), options, name)


def site_of_message(message: OccupancyGrid, options: SiteOptions, name: str) -> MappedSite:
    """Returns the site of a nav_msgs/OccupancyGrid; raises SiteError if it is wrong or rotated."""
    info = message.info
    if len(message.data) != info.height * info.width or not message.data:
        raise SiteError(f'{name}: the map should have {info.height} x {info.width} cells, but '
                        f'has {len(message.data)}.')
    turned = abs(info.origin.orientation.x) + abs(info.origin.orientation.y) \
        + abs(info.origin.orientation.z)
    origin = info.origin.position.x, info.origin.position.y
    finite = np.isfinite((*origin, info.resolution)).all()
    if turned > 1e-6 or not finite or info.resolution <= 0.0:
        raise SiteError(f'{name}: the map is rotated, or its resolution or origin are not numbers; '
                        'such a map cannot be used.')
    cells = np.array(message.data, np.int8).reshape(info.height, info.width)
    return site_of_grid(cells, float(info.resolution), origin, options, name)


def _received(topic: str) -> OccupancyGrid:
    import rosgraph
    import rospy
    from nav_msgs.msg import OccupancyGrid

    from node_lifecycle.log_file import init_node
    if not rosgraph.is_master_online():
        raise SiteError(f'{topic} cannot be received: there is no ROS master.')
    if not rospy.core.is_initialized():
        init_node('graph_editor_map', anonymous=True, disable_signals=True)
    try:
        return rospy.wait_for_message(topic, OccupancyGrid, PATIENCE)
    except rospy.ROSException:
        raise SiteError(f'No map was published on {topic} within {PATIENCE:g} s.') from None
