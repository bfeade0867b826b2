"""Knowledge of the robot's motion, from topics and from signals of the vehicle file."""
from __future__ import annotations

import math

import pytest
import yaml
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState
from vda_builders import PACKAGE

from omron_ld90_msgs.msg import Motion
from vda5050_protocol.values import EmergencyStop
from vda5050_vehicle.nodes import robot_watch
from vda5050_vehicle.nodes.robot_watch import RobotWatch, read_signals


@pytest.fixture
def topics(monkeypatch):
    """Replaces the subscribers of ROS and the clock; returns the callbacks of each topic."""
    callbacks = {}

    def subscribe(topic, _type, callback, **_):
        callbacks.setdefault(topic, []).append(callback)
    monkeypatch.setattr(robot_watch.rospy, 'Subscriber', subscribe)
    monkeypatch.setattr(robot_watch.time, 'monotonic', lambda: topics_now[0])
    return callbacks


topics_now = [100.0]


def tell(topics, topic, message):
    for callback in topics[topic]:
        callback(message)


@pytest.fixture
def watch(topics):
    topics_now[0] = 100.0
    document = yaml.safe_load((PACKAGE / 'config' / 'ld90' / 'vehicle.yaml').read_text())
    return RobotWatch(read_signals(document), 3.0, '', 'map', lambda: None)


def test_nothing_is_known_before_anything_was_told(watch):
    view = watch.view()
    assert (view.velocity, view.standing, view.epoch, view.stands) == (None, None, 0, False)


def test_motion_that_was_told_once_holds_until_another_is_told(watch, topics):
    tell(topics, 'motion', Motion(epoch=7, state=Motion.STANDING))
    topics_now[0] += 60.0
    assert (watch.view().standing, watch.view().epoch) == (True, 7)
    tell(topics, 'motion', Motion(epoch=8, state=Motion.DRIVING))
    assert (watch.view().standing, watch.view().epoch) == (False, 8)
    tell(topics, 'motion', Motion(epoch=8, state=Motion.UNKNOWN))
    assert watch.view().standing is None, 'the velocity must decide'


def test_the_emergency_stop_holds_until_motion_tells_its_end(watch, topics):
    assert watch.view().e_stop is EmergencyStop.NONE
    tell(topics, 'motion', Motion(epoch=7, emergency_stop=True))
    topics_now[0] += 60.0
    assert watch.view().e_stop is EmergencyStop.MANUAL
    tell(topics, 'motion', Motion(epoch=8))
    assert watch.view().e_stop is EmergencyStop.NONE


def test_a_velocity_is_known_with_its_time_and_not_for_long(watch, topics):
    tell(topics, 'odom', Odometry())
    topics_now[0] += 2.0
    assert (watch.view().seen_at, watch.view().stands) == (100.0, True)
    topics_now[0] += 2.0
    assert (watch.view().velocity, watch.view().stands) == (None, False)


def pose_at(x: float) -> PoseStamped:
    message = PoseStamped()
    message.header.frame_id = 'map'
    message.pose.position.x, message.pose.orientation.w = x, 1.0
    return message


def test_a_robot_that_tells_only_where_it_is_stands_once_that_stays_the_same(watch, topics):
    for x, stands in ((1.0, False), (1.3, False), (1.31, False), (1.3, True), (1.6, False)):
        topics_now[0] += 1.0
        tell(topics, 'pose', pose_at(x))
        assert watch.view().stands is stands, x
        assert watch.view().seen_at == topics_now[0]


def test_one_pose_however_old_is_no_robot_that_stands(watch, topics):
    tell(topics, 'pose', pose_at(1.0))
    topics_now[0] += 2.5
    assert not watch.view().stands


def test_a_robot_that_was_not_heard_meanwhile_may_have_been_elsewhere(watch, topics):
    for pause, stands in ((0.0, False), (2.5, False), (1.0, False), (1.0, True)):
        topics_now[0] += pause
        tell(topics, 'pose', pose_at(1.0))
        assert watch.view().stands is stands, pause


def test_poses_count_for_nothing_where_the_robot_has_words_for_its_motion(watch, topics):
    tell(topics, 'motion', Motion(epoch=7, state=Motion.DRIVING))
    for _ in range(5):
        topics_now[0] += 1.0
        tell(topics, 'pose', pose_at(1.0))
    assert not watch.view().stands


@pytest.mark.parametrize('told', [23.0, 100.0, 1.5, -0.01, -1.0, math.inf, math.nan])
def test_a_charge_out_of_range_leaves_the_last_one_and_is_never_a_full_or_an_empty_battery(
        watch, topics, told):
    tell(topics, 'battery_state', BatteryState(percentage=0.5, voltage=math.nan))
    tell(topics, 'battery_state', BatteryState(percentage=told, voltage=math.nan))
    assert watch.view().battery.charge == 50.0
