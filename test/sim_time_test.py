#!/usr/bin/env python3
"""If ROS time stands still or steps back, periodic work goes on; every node reports the clock."""
from __future__ import annotations

import threading
import time
import unittest
from typing import Set

import rosnode
import rospy
from actionlib_msgs.msg import GoalStatusArray
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from rosgraph_msgs.msg import Clock
from visualization_msgs.msg import InteractiveMarkerUpdate

from itrci_nav_msgs.msg import FleetState, MissionRequest, MissionStatus
from omron_ld90_msgs.msg import LinkState
from system_support import Recorder, connected_publisher, run_cases, wait_until

ROBOT = 'omron_ld90'
BEGIN, BACK = 5000.0, 1000.0  # s of ROS time


class PublishedClock:
    """Publishes /clock in real time; the present time can be set."""

    def __init__(self) -> None:
        self._publisher = rospy.Publisher('/clock', Clock, queue_size=1)
        self._begin, self._set_at = BEGIN, time.monotonic()
        threading.Thread(target=self._run, daemon=True).start()

    def set(self, seconds: float) -> None:
        self._begin, self._set_at = seconds, time.monotonic()

    def _run(self) -> None:
        while not rospy.is_shutdown():
            now = self._begin + time.monotonic() - self._set_at
            self._publisher.publish(Clock(rospy.Time.from_sec(now)))
            time.sleep(0.02)


class SimTime(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('sim_time_test')
        cls.poses = Recorder(f'/{ROBOT}/pose', PoseStamped)
        cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)
        cls.fleet = Recorder('/fleet_state', FleetState)
        cls.missions = Recorder('/mission_status', MissionStatus)
        cls.requests = connected_publisher('/mission_request', MissionRequest, to='path_supervisor')

    def wait_for_periodic(self, what: str) -> None:
        """Waits until each periodic topic has had three more messages."""
        for topic, kind in ((f'/{ROBOT}/execute_command/status', GoalStatusArray),
                            (f'/{ROBOT}/link_state', LinkState),
                            (f'/{ROBOT}/interactive_goals/update', InteractiveMarkerUpdate),
                            ('/fleet_state', FleetState)):
            recorder = Recorder(topic, kind)
            wait_until(lambda recorder=recorder: len(recorder.messages) >= 3, 20.0,
                       f'{topic} comes {what}')

    def nodes_with_clock_at(self, level: int) -> Set[str]:
        """Returns the nodes whose newest status about the clock has this level."""
        newest = {status.name: status.level for message in list(self.diagnostics.messages)
                  for status in message.status if status.name.endswith(': clock')}
        return {'/' + name.rsplit(': ', 1)[0] for name, found in newest.items() if found == level}

    def drive(self, id: int, to: int) -> None:
        self.requests.publish(request_id=id, destination_vertices_id=[to])
        end = self.missions.wait_for(
            lambda status: status.request_id == id and status.state in (
                MissionStatus.SUCCEEDED, MissionStatus.FAILED, MissionStatus.REFUSED), 60,
            f'end of mission {id}')
        self.assertEqual(MissionStatus.SUCCEEDED, end.state, end.reason)

    def test_1_without_a_clock_periodic_work_goes_on_and_every_node_says_what_it_waits_for(self):
        self.wait_for_periodic('without /clock')
        others = ('rosout', 'ld90_sim', 'sim_time', 'body_state_publisher')
        nodes = {node for node in rosnode.get_node_names()
                 if node.rsplit('/', 1)[-1] not in others}
        wait_until(lambda: nodes <= self.nodes_with_clock_at(DiagnosticStatus.ERROR), 20.0,
                   f'the message of each of {nodes} that no /clock comes')

    def test_2_when_the_clock_comes_the_robot_drives(self):
        type(self).clock = PublishedClock()
        self.poses.wait_for(lambda pose: pose.header.stamp.to_sec() >= BEGIN, 20.0, 'a pose')
        self.fleet.wait_for(lambda state: state.robots and state.robots[0].pose.edge_id, 30.0,
                            'the robot on the graph')
        self.drive(1, 18)
        wait_until(lambda: not self.nodes_with_clock_at(DiagnosticStatus.ERROR), 10.0,
                   'no message about the clock any more')

    def test_3_after_the_clock_has_stepped_back_everything_goes_on(self):
        heard = len(self.poses.messages)
        self.clock.set(BACK)
        self.poses.wait_for(lambda pose: pose.header.stamp.to_sec() < BEGIN, 20.0,
                            'a pose of the new time', after=heard)
        self.wait_for_periodic('after the step')
        self.drive(2, 39)


if __name__ == '__main__':
    run_cases(__file__)
