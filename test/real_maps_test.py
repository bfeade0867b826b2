#!/usr/bin/env python3
"""A user's own map: the full stack shows the map of a real LD robot correctly, and drives to goals.

The maps belong to real robots and are not in this repository. Without them the tests are skipped.
"""
from __future__ import annotations

import math
import os
import unittest
from pathlib import Path

import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid
from visualization_msgs.msg import MarkerArray

from system_support import Launched, Recorder, drive_to, run_cases

MAPS = Path(os.environ.get('LD90_REAL_MAPS') or '/nowhere')  # '/nowhere': there are no maps


class RealMaps(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('real_maps')

    def check(self, name: str, occupied: int, areas: int, first_area: tuple, goal: str,
              goal_at: tuple) -> None:
        """Shows the map in a namespace of its own, compares it with known facts, and drives."""
        file = MAPS / name
        if not file.exists():
            self.skipTest(f'{file} does not exist')
        robot = name.replace('-', '_').replace('.map', '')
        topic = f'/{robot}'.__add__
        with Launched('full_stack.launch', map_file=file, robot_name=robot, sim_speed=10,
                      rviz='false', arcl_port=os.environ['LD90_ARCL_PORT'],
                      outgoing_port=os.environ['LD90_OUTGOING_PORT']):
            grid = Recorder(topic('/map'), OccupancyGrid).wait_for(lambda m: True, 60, 'map')
            self.assertEqual(sum(1 for cell in grid.data if cell == 100), occupied)

            drawn = Recorder(topic('/map_markers/forbidden_areas'), MarkerArray).wait_for(
                lambda message: len(message.markers) > 1, 30, 'forbidden areas')
            cubes = [marker for marker in drawn.markers if marker.scale.x > 0 and not marker.text]
            self.assertEqual(len(cubes), areas)
            nearest = min(math.hypot(cube.pose.position.x - first_area[0],
                                     cube.pose.position.y - first_area[1]) for cube in cubes)
            self.assertLess(nearest, 0.01, f'no forbidden area with its centre at {first_area}')

            poses = Recorder(topic('/pose'), PoseStamped)
            poses.wait_for(lambda message: True, 30, 'pose of the robot')
            drive_to(robot, goal, timeout=120)
            poses.wait_for(
                lambda m: math.hypot(m.pose.position.x - goal_at[0],
                                     m.pose.position.y - goal_at[1]) < 0.1,
                10, f'pose at {goal_at}', after=len(poses.messages) - 1)

    def test_site_a_six_areas_turned_by_90_and_180_degrees_and_a_goal(self) -> None:
        # FA1: from (-18561, -13725) to (-15055, -7739), rotated by 180 degrees about the origin.
        self.check('omron-ld-site-a.map', occupied=44440, areas=6, first_area=(16.808, 10.732),
                   goal='Goal1', goal_at=(1.240, 8.152))

    def test_site_b_a_dock_with_a_blank_in_its_name_and_two_goals(self) -> None:
        # (-3237, -1352) to (2731, 1246), rotated by -90 degrees about the origin.
        self.check('omron-ld-site-b.map', occupied=3737, areas=4, first_area=(-0.053, 0.253),
                   goal='Goal2', goal_at=(4.472, 1.175))


if __name__ == '__main__':
    run_cases(__file__)
