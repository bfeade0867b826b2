"""Parameters that have the same meaning in several nodes."""
from __future__ import annotations

from typing import Optional, Tuple

import rospy

from node_lifecycle import ConfigurationError, parameter
from trajectory_graph import Graph, GraphError, load_graph


def base_frame() -> str:
    """Returns `~base_frame`, the frame of the robot; default: `<namespace>/base_link`."""
    return parameter('~base_frame', _frame_of_robot('base_link'))


def laser_frame() -> str:
    """Returns `~laser_frame`, the frame of the laser; default: `<namespace>/laser_link`."""
    return parameter('~laser_frame', _frame_of_robot('laser_link'))


def _frame_of_robot(link: str) -> str:
    namespace = rospy.get_namespace().strip('/')
    return f'{namespace}/{link}' if namespace else link


def trajectory_graph() -> Optional[Graph]:
    """Returns the graph in `~graph_file`; None if the parameter is empty.

    Raises ConfigurationError.
    """
    file = parameter('~graph_file', '')
    try:
        return load_graph(file) if file else None
    except GraphError as error:
        raise ConfigurationError(f'~graph_file: {error}') from None


def map_sources() -> Tuple[str, ...]:
    """Returns the files from which `~map_file` is made; a node waits until the map is newer.

    Empty if `~base_map` is empty.
    """
    base_map = parameter('~base_map', '')
    return (base_map, parameter('~graph_file', '')) if base_map else ()
