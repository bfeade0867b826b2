"""The topic `motion`, and the file that keeps the records of drives over a restart."""
from __future__ import annotations

import dataclasses
import json
import os
from contextlib import suppress
from typing import Optional

import rospy

from json_records import from_json, to_json
from node_lifecycle import warn
from node_lifecycle.kept_files import hold, in_ros_home, replace_json
from omron_arcl.records import DriveMemory, RobotMotion
from omron_ld90_msgs import msg

ROBOT_ID = 'robot_id'


class MotionFile:
    """Keeps the `DriveMemory` of one robot in a file.

    path -- path of the file; a relative path begins in ROS_HOME; empty: no file
    robot_id -- id of a simulated robot, new at each start of the simulator; empty: a real robot
    """

    def __init__(self, path: str, robot_id: str = '') -> None:
        self._path, self._robot_id = in_ros_home(path), robot_id
        self._kept: Optional[DriveMemory] = None

    def hold(self) -> None:
        """Reserves the file. Raises ConfigurationError if another controller uses it."""
        hold(self._path, '~motion_file')

    def read(self) -> Optional[DriveMemory]:
        """Returns the stored memory. None: there is none, it is of another robot, or it cannot be
        read.

        If the folder is read-only, the stored epoch may be out of date. Then the memory is returned
        with epoch 0. No program knows this epoch, so no program drives on because of it. An owed
        stop still counts.
        """
        try:
            with open(self._path, encoding='utf-8') as stream:
                content = dict(json.load(stream))
            if content.pop(ROBOT_ID, '') != self._robot_id:
                return None
            memory = from_json(DriveMemory, content, added=(
                'last_commands', 'ending', 'acknowledged_by', 'doubt', 'verb', 'stands_for',
                'is_cancelled', 'order', 'foreign_epoch'))
        except FileNotFoundError:
            return None
        except (OSError, ValueError, TypeError) as error:
            rospy.logwarn('%s cannot be read, so the last driver of the robot is unknown: %s',
                          self._path, error)
            return None
        if os.access(os.path.dirname(os.path.abspath(self._path)), os.W_OK):
            return memory
        self._warn('its folder is read-only')
        return dataclasses.replace(memory, epoch=0, previous_epoch=0)

    def keep(self, memory: DriveMemory) -> None:
        """Replaces the file with a new one.

        The file is not forced to the disk, because a stop must not wait for a disk. If the file
        cannot be written, the robot is still driven, but after a restart its last driver is
        unknown.
        """
        if not self._path or memory == self._kept:
            return
        content = to_json(memory)
        if self._robot_id:
            content[ROBOT_ID] = self._robot_id
        try:
            try:
                replace_json(self._path, content)
            except OSError:
                with suppress(OSError):
                    os.unlink(self._path)  # the file is out of date; this frees some space
                replace_json(self._path, content)
        except OSError as error:
            self._kept = None
            self._warn(str(error.strerror))
        else:
            self._kept = memory

    def _warn(self, why: str) -> None:
        warn('motion_file', f'{self._path} cannot be written ({why}): after a restart '
                            'omron_controller would not know the last driver of the robot.')


class MotionTopic:
    """Publishes `motion`, latched."""

    def __init__(self) -> None:
        self._publisher = rospy.Publisher('motion', msg.Motion, queue_size=20, latch=True,
                                          tcp_nodelay=True)

    def publish(self, motion: RobotMotion) -> None:
        """Publishes the new state."""
        message = message_of(motion)
        message.header.stamp = rospy.Time.now()
        self._publisher.publish(message)


def message_of(motion: RobotMotion) -> msg.Motion:
    """Returns a `RobotMotion` as a message, without its stamp."""
    memory = motion.memory
    return msg.Motion(
        epoch=memory.epoch, previous_epoch=memory.previous_epoch,
        foreign_epoch=memory.foreign_epoch, giver=memory.giver.name,
        state=int(motion.state), emergency_stop=motion.emergency_stop, goal=memory.goal,
        stop_owed=memory.stop_owed, cause=int(memory.cause), reason=memory.reason,
        last_commands=[msg.LastCommand(last.giver, last.number, int(last.fate), last.foreign_epoch)
                       for last in memory.last_commands])
