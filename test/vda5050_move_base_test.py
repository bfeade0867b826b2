#!/usr/bin/env python3
"""A VDA 5050 master drives a robot that has the action move_base but no graph."""
from __future__ import annotations

import math
import sys
import threading
import time
import unittest
from typing import List, Tuple

import actionlib
import rospy
import rostest
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import Odometry

from node_lifecycle.periodic import Periodic
from system_support import kill_node
from vda5050_bench.master import BenchMaster, Message
from vda5050_bench.track import Stop, Track, node_ids
from vda5050_mqtt.link import Broker
from vda5050_mqtt.own_broker import OwnBroker

PERIOD = 0.05  # s
FAST = 3.0  # m/s
UNHURRIED = 0.5  # m/s
NEAR = 0.45  # distance from a goal, m; here the robot slows down, and gets the next goal
SLOW = 0.15  # m/s; so there are 3 s for the next goal, even on a computer that is busy
CRAWL = 0.05  # m/s
HALL = Track(tuple(Stop(name, 2.0 * i, 0.0) for i, name in enumerate('ABCD')),
             ('AB', 'BC', 'CD'), ('BA', 'CB', 'DC'))


class Trolley:
    """A robot that drives straight to each goal of move_base, until this goal is cancelled."""

    def __init__(self) -> None:
        self.goals: List[Tuple[float, float]] = []
        self.blocked_at = math.inf  # x (m); no goal beyond it is reached
        self.speed = FAST  # m/s, far from a goal
        self.x = 0.0
        self._speed = 0.0
        self._lock = threading.Lock()
        self._poses = rospy.Publisher('/trolley/pose', PoseStamped, queue_size=1)
        self._odometry = rospy.Publisher('/trolley/odom', Odometry, queue_size=1)
        Periodic('trolley', PERIOD, self._publish)

    def start_move_base(self) -> None:
        """Starts the action. Until then, the robot reports its pose but accepts no goals."""
        self._server = actionlib.SimpleActionServer('/trolley/move_base', MoveBaseAction,
                                                    self._drive, auto_start=False)
        self._server.start()

    def _drive(self, goal: MoveBaseGoal) -> None:
        target = goal.target_pose.pose.position
        self.goals.append((target.x, target.y))
        while not rospy.is_shutdown():
            left = target.x - self.x
            if self._server.is_preempt_requested():
                if not self._server.is_new_goal_available():
                    self._speed = 0.0
                self._server.set_preempted()
                return
            if self.x >= self.blocked_at:
                self._speed = 0.0
                self._server.set_aborted(text='the way is blocked')
                return
            if abs(left) < self.speed * PERIOD:
                self._speed = 0.0
                self._server.set_succeeded()
                return
            speed = min(self.speed, SLOW) if abs(left) < NEAR else self.speed
            self._speed = math.copysign(speed, left)
            self.x += self._speed * PERIOD
            time.sleep(PERIOD)

    def _publish(self) -> None:
        pose, odometry = PoseStamped(), Odometry()
        pose.header.frame_id = 'map'
        pose.pose.position.x, pose.pose.orientation.w = self.x, 1.0
        odometry.twist.twist.linear.x = self._speed
        self._poses.publish(pose)
        self._odometry.publish(odometry)


def errors(state: Message) -> List[Tuple[str, str]]:
    """Returns the types and texts of the errors in a state."""
    return [(error['errorType'], error['errorDescription']) for error in state['errors']]


class MoveBase(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('vda5050_move_base_test')
        host, _, port = rospy.get_param('~broker').rpartition(':')
        cls.own_broker = OwnBroker(int(port))
        cls.trolley = Trolley()
        cls.master = BenchMaster(Broker(host, int(port)), 'uagv/v2/Other/trolley')
        cls.master.wait(lambda s: not s['errors'], 20, 'a vehicle without errors')

    @classmethod
    def tearDownClass(cls) -> None:
        cls.master.close()
        cls.own_broker.close()

    def tearDown(self) -> None:
        self.assertEqual(self.master.checker.violations, [])

    def test_1_nodes_are_passed_without_stopping_and_the_horizon_is_not_driven(self) -> None:
        """The order is sent before move_base has started."""
        master, self.trolley.speed = self.master, UNHURRIED
        heard = master.send('order', HALL.order('there', base=3))
        master.wait(lambda s: s['orderId'] == 'there', 10, 'the order', after=heard)
        self.trolley.start_move_base()
        state = master.wait(lambda s: s['lastNodeId'] == 'C' and not s['driving'], 20,
                            'standing at the end of the base', after=heard)
        self.assertEqual(node_ids(state), ['D'])
        self.assertEqual(self.trolley.goals, [(2.0, 0.0), (4.0, 0.0)])
        past_b = [s['driving'] for s in master.messages['state'] if s['lastNodeId'] == 'B']
        self.assertTrue(past_b and all(past_b), 'it stopped on the way')
        heard = master.send('order', HALL.part(2).order('there', 1, first_sequence=4))
        master.wait(lambda s: s['orderUpdateId'] == 1 and not s['nodeStates'] and not s['driving'],
                    20, 'the end of the order', after=heard)
        self.assertEqual(self.trolley.goals[2:], [(6.0, 0.0)])

    def test_2_a_pause_stops_the_robot_and_the_goal_is_sent_anew_after_it(self) -> None:
        master, begun, self.trolley.speed = self.master, len(self.trolley.goals), UNHURRIED
        heard = master.send('order', HALL.reversed().order('back'))
        master.wait(lambda s: s['lastNodeId'] == 'C' and s['driving'], 20, 'under way', after=heard)
        self.trolley.speed = CRAWL  # the vehicle is paused before B
        self.assertEqual(master.ended(master.act('startPause'))['actionStatus'], 'FINISHED')
        self.assertFalse(master.state['driving'])
        paused = len(self.trolley.goals)
        self.assertEqual(self.trolley.goals[paused - 1], (2.0, 0.0))
        self.trolley.speed = UNHURRIED
        self.assertEqual(master.ended(master.act('stopPause'))['actionStatus'], 'FINISHED')
        master.wait(lambda s: s['lastNodeId'] == 'A' and not s['nodeStates'] and not s['driving'],
                    20, 'the end of the order', after=heard)
        self.assertEqual(self.trolley.goals[begun:], [(4.0, 0.0), (2.0, 0.0), (2.0, 0.0),
                                                      (0.0, 0.0)])

    def test_3_a_goal_that_nobody_follows_any_more_is_cancelled(self) -> None:
        master, begun, self.trolley.speed = self.master, len(self.trolley.goals), CRAWL
        heard = master.send('order', HALL.order('killed'))
        master.wait(lambda s: s['orderId'] == 'killed' and s['driving'], 10, 'under way',
                    after=heard)
        heard = master.count()
        master.checker.restarted()
        kill_node('/trolley/vda5050_vehicle')
        master.wait(lambda s: errors(s) == [('driveError',
                                               'the adapter was restarted during the drive')]
                    and not s['driving'], 20, 'a robot that stands, for a reason', after=heard)
        self.assertEqual(self.trolley.goals[begun:], [(2.0, 0.0)])
        self.assertEqual(master.ended(master.act('cancelOrder'))['actionStatus'], 'FINISHED')
        self.trolley.x, self.trolley.speed = 0.0, FAST  # the robot was carried back

    def test_4_what_move_base_cannot_reach_holds_the_order_until_it_is_cancelled(self) -> None:
        master = self.master
        self.trolley.blocked_at = 3.0
        heard = master.send('order', HALL.order('blocked'))
        state = master.wait(lambda s: s['errors'] and not s['driving'], 10, 'an error', after=heard)
        self.assertEqual(errors(state), [('driveError', 'the way is blocked')])
        self.assertEqual(node_ids(state), ['C', 'D'])
        tried = len(self.trolley.goals)
        self.assertEqual(master.ended(master.act('cancelOrder'))['actionStatus'], 'FINISHED')
        self.assertEqual((node_ids(master.state), master.state['errors']), ([], []))
        self.assertEqual(len(self.trolley.goals), tried, 'a goal was repeated')


if __name__ == '__main__':
    rostest.rosrun('omron_ld90', 'vda5050_move_base', MoveBase, sys.argv)
