"""The RViz configuration of a fleet: `fleet.rviz` of graph_fleet_manager, and displays per robot.
"""
from __future__ import annotations

import os
from typing import Any, Dict, Sequence

import rospkg
import yaml

from fleet_bringup.options import Options
from fleet_bringup.robot_entries import LD90, RobotEntry


def rviz_text(entries: Sequence[RobotEntry], options: Options) -> str:
    """Returns the content of the configuration file for RViz."""
    template = os.path.join(rospkg.RosPack().get_path('graph_fleet_manager'), 'rviz', 'fleet.rviz')
    with open(template, encoding='utf-8') as stream:
        configuration = yaml.safe_load(stream)
    displays = configuration['Visualization Manager']['Displays']
    displays += [_lasers(entry) for entry in entries if entry.robot.driver == LD90
                 and (options.lasers or not entry.is_simulated)]
    return yaml.safe_dump(configuration, sort_keys=False)


def _lasers(entry: RobotEntry) -> Dict[str, Any]:
    laser = {
        'Class': 'rviz/PointCloud2', 'Name': 'Laser', 'Topic': f'/{entry.name}/laser_cloud',
        'Alpha': 1, 'Color': '135; 206; 250', 'Color Transformer': 'FlatColor',
        'Position Transformer': 'XYZ', 'Size (m)': 0.05, 'Size (Pixels)': 3,
        'Style': 'Flat Squares', 'Decay Time': 0, 'Queue Size': 10, 'Selectable': False,
        'Enabled': True, 'Value': True}
    return {'Class': 'rviz/Group', 'Name': entry.name, 'Enabled': True, 'Displays': [laser]}
