#!/usr/bin/env python3
"""A node that has only one publisher at 2 Hz: the floor of one node."""
from __future__ import annotations

import rospy
from std_msgs.msg import String

import node_program

rospy.init_node('bare')
publisher = rospy.Publisher(f'/bare/{rospy.get_name().strip("/")}', String, queue_size=1)
node_program.node_started()
rate = rospy.Rate(2.0)  # noqa: TID251, as in the tutorials of ROS
while not rospy.is_shutdown():
    publisher.publish('x')
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
