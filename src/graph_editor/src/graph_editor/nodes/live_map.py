"""Maps for the programs: files, or with `topic:NAME` the occupancy grid that is published there.

ROS is imported for a topic only: files need no ROS master.
"""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graph_editor.errors import SiteError
from graph_editor.site import Site, SiteOptions, load_site, site_of_grid

if TYPE_CHECKING:
    from nav_msgs.msg import OccupancyGrid

TOPIC = 'topic:'
PATIENCE = 10.0  # s for a map to come


def load_map(name: str, options: SiteOptions) -> Site:
    """The site of a map file, or of the topic after `topic:`; raises SiteError or MapError."""
    if not name.startswith(TOPIC):
        return load_site(name, options)
    return site_of_message(_received(name[len(TOPIC):]), options, name)


def site_of_message(message: OccupancyGrid, options: SiteOptions, name: str) -> Site:
    """The site of a nav_msgs/OccupancyGrid; raises SiteError for one that is wrong or turned."""
    info = message.info
    if len(message.data) != info.height * info.width or not message.data:
        raise SiteError(f'{name}: the map says it has {info.height} x {info.width} cells, but '
                        f'holds {len(message.data)}.')
    turned = abs(info.origin.orientation.x) + abs(info.origin.orientation.y) \
        + abs(info.origin.orientation.z)
    origin = info.origin.position.x, info.origin.position.y
    finite = np.isfinite((*origin, info.resolution)).all()
    if turned > 1e-6 or not finite or info.resolution <= 0.0:
        raise SiteError(f'{name}: the map is turned, or its resolution or origin are no numbers; '
                        'such a map cannot be used.')
    cells = np.array(message.data, np.int8).reshape(info.height, info.width)
    return site_of_grid(cells, float(info.resolution), origin, options, name)


def _received(topic: str) -> OccupancyGrid:
    import rosgraph
    import rospy
    from nav_msgs.msg import OccupancyGrid

    from node_lifecycle.log_file import init_node
    if not rosgraph.is_master_online():
        raise SiteError(f'{topic} cannot be heard: there is no ROS master.')
    if not rospy.core.is_initialized():
        init_node('graph_editor_map', anonymous=True, disable_signals=True)
    try:
        return rospy.wait_for_message(topic, OccupancyGrid, PATIENCE)
    except rospy.ROSException:
        raise SiteError(f'No map was published on {topic} within {PATIENCE:g} s.') from None
