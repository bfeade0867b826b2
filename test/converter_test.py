#!/usr/bin/env python3
"""The robot drives on a map that the converter has just made; map_visualisation shows the map."""
from __future__ import annotations

import os
import unittest

import rospy
from std_msgs.msg import String
from visualization_msgs.msg import Marker, MarkerArray

from omron_ld90_msgs.msg import LinkState
from system_support import Recorder, connected_publisher, run_cases, wait_until

VERTICES = {'1', '2', '4', '6', '8', '10', '12', '14', '18', '20', '22', '24', '26', '27', '32',
            '33', '35', '39', '40', '41', '42', '47', '49', '52'}


class ConverterTest(unittest.TestCase):
    """Converter, simulated robot, controller and map_visualisation start at the same time."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node('converter_test')
        cls.map_file = rospy.get_param('~map_file')
        cls.addClassCleanup(cls._remove_map)
        wait_until(lambda: os.path.exists(cls.map_file), 30, f'{cls.map_file} is made')

    @classmethod
    def _remove_map(cls):
        if os.path.exists(cls.map_file):
            os.unlink(cls.map_file)

    def test_the_robot_offers_every_vertex_as_a_goal_and_drives_to_one(self):
        link = Recorder('/omron_ld90/link_state', LinkState)
        link.wait_for(lambda m: m.link == LinkState.COMMANDS and m.state == LinkState.CONNECTED, 60,
                      'login at the robot')
        said = Recorder('/omron_ld90/arcl_response', String)
        command = connected_publisher('/omron_ld90/send_command', String, to='omron_controller')

        command.publish('getGoals')
        said.wait_for(lambda m: m.data == 'End of goals', 10, 'end of the list of goals')
        goals = {m.data[len('Goal: '):] for m in said.messages if m.data.startswith('Goal: ')}
        self.assertEqual(goals, VERTICES)

        command.publish('goto 6')
        said.wait_for(lambda m: m.data == 'Arrived at 6', 60, 'arrival at vertex 6')

    def test_the_map_is_shown_with_its_goals_and_dock(self):
        goals = Recorder('/omron_ld90/map_markers/goals', Marker)
        docks = Recorder('/omron_ld90/map_markers/docks', Marker)
        names = Recorder('/omron_ld90/map_markers/goal_names', MarkerArray)
        goals.wait_for(lambda m: len(m.points) == len(VERTICES), 30, 'marker of 24 goals')
        docks.wait_for(lambda m: len(m.points) == 1, 30, 'marker of the dock')
        names.wait_for(lambda m: VERTICES.issubset(x.text for x in m.markers), 30,
                       'array with the names of all vertices')


if __name__ == '__main__':
    run_cases(__file__)
