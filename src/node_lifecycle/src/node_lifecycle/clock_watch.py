"""Reports when ROS time stands still or steps back, for nodes under /use_sim_time.

Such a node works, but everything that it publishes has the same time. Receivers then ignore it,
because they see nothing new. Without this report, nothing would name the cause.
"""
from __future__ import annotations

import time
from typing import Callable, Optional

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from node_lifecycle.diagnostics import publish_diagnostics

STILL = 3.0  # s after which the time counts as standing still
_REMEDY = ('Start what publishes /clock (a simulator, `rosbag play --clock`), or call '
           '`rosparam set /use_sim_time false` and restart the nodes.')


class ClockWatch:
    """The task `clock` of a node's diagnostics.

    It also logs when ROS time stops, steps back, or moves on again.
    """

    def __init__(self, ros_time: Callable[[], float] = rospy.get_time,
                 clock: Callable[[], float] = time.monotonic) -> None:
        self._ros_time, self._clock = ros_time, clock
        self._last = ros_time()
        self._since = clock()
        self._is_reported = False

    def diagnose(self, status: DiagnosticStatusWrapper) -> None:
        """Fills in a status; diagnostic_updater calls this."""
        before, self._last = self._last, self._ros_time()
        if self._last != before:
            self._since = self._clock()
        if self._last < before:
            rospy.logwarn('ROS time stepped back from %.3f s to %.3f s, as when a bag is played in '
                          'a loop or a simulated world is reset.', before, self._last)
        trouble = self._trouble()
        if trouble and not self._is_reported:
            rospy.logerr('%s', trouble)
        if self._is_reported and not trouble:
            rospy.loginfo('ROS time moves on again.')
        self._is_reported = trouble is not None
        status.add('ROS time (s)', f'{self._last:.3f}')
        if trouble:
            status.summary(DiagnosticStatus.ERROR, trouble)
        else:
            status.summary(DiagnosticStatus.OK, 'ROS time comes from /clock, and moves on')

    def _trouble(self) -> Optional[str]:
        still = self._clock() - self._since
        if still < STILL:
            return None
        if self._last == 0.0:
            return (f'/use_sim_time is true, and no /clock came for {still:.0f} s: there is no '
                    f'time. {_REMEDY}')
        return (f'/use_sim_time is true, and /clock has not moved for {still:.0f} s: ROS time '
                f'stands still at {self._last:.3f} s. {_REMEDY}')


def watch_clock() -> None:
    """Publishes `<node>: clock` in /diagnostics if ROS time comes from /clock."""
    if not rospy.rostime.is_wallclock():
        publish_diagnostics('none', {'clock': ClockWatch().diagnose})
