"""The topic `motion`, and the file that keeps the records of drives over a restart."""
from __future__ import annotations

import dataclasses
import json
import os
from contextlib import suppress
from typing import Any, Dict, Optional

import rospy

from node_lifecycle import warn
from omron_arcl.execution import Giver
from omron_arcl.records import Cause, CommandFate, Fate, Kind, LastCommand, Memory, Motion, Record
from omron_ld90.nodes.support.kept_files import hold, in_ros_home, replace_json
from omron_ld90_msgs import msg


class MotionFile:
    """Keeps a `Memory`; a relative path begins in ROS_HOME, an empty one means no file."""

    def __init__(self, path: str) -> None:
        self._path = in_ros_home(path)
        self._kept: Optional[Memory] = None

    def hold(self) -> None:
        """Raises ConfigurationError if another controller keeps its memory in the file."""
        hold(self._path, '~motion_file')

    def read(self) -> Optional[Memory]:
        """The stored memory; None if there is none, or it cannot be read.

        If the folder is read-only, the stored epoch may be out of date. Then epoch 0 is returned,
        which no program knows, so that no program drives on because of it. An owed stop still
        counts.
        """
        try:
            with open(self._path, encoding='utf-8') as stream:
                content = json.load(stream)
            memory = Memory(**{
                **content, 'cause': Cause(content['cause']),
                'records': tuple(_record(record) for record in content['records']),
                'last_commands': tuple(
                    LastCommand(last['giver'], last['number'], CommandFate(last['fate']))
                    for last in content.get('last_commands', ()))})
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError) as error:
            rospy.logwarn('%s cannot be read, so the last driver of the robot is unknown: %s',
                          self._path, error)
            return None
        if os.access(os.path.dirname(os.path.abspath(self._path)), os.W_OK):
            return memory
        self._warn('its folder is read-only')
        return dataclasses.replace(memory, epoch=0, previous_epoch=0)

    def keep(self, memory: Memory) -> None:
        """Replaces the file by a complete new one.

        The file is not forced to the disk, because a stop must not wait for a disk. If it cannot be
        written, the robot is still driven; only a restart would know less.
        """
        if not self._path or memory == self._kept:
            return
        content = dataclasses.asdict(memory)
        for record in content['records']:
            record.update(kind=record['kind'].value, fate=record['fate'].value)
        try:
            try:
                replace_json(self._path, content)
            except OSError:
                with suppress(OSError):
                    os.unlink(self._path)  # it is out of date, and its space may be enough
                replace_json(self._path, content)
        except OSError as error:
            self._kept = None
            self._warn(str(error.strerror))
        else:
            self._kept = memory

    def _warn(self, why: str) -> None:
        warn('motion_file', f'{self._path} cannot be written ({why}): after a restart '
                            'omron_controller would not know the last driver of the robot.')


def _record(content: Dict[str, Any]) -> Record:
    """The record that was stored as `content`; raises ValueError, KeyError or TypeError."""
    return Record(**{**content, 'kind': Kind(content['kind']), 'fate': Fate(content['fate']),
                     'ending': CommandFate(content.get('ending', CommandFate.NOT_OBEYED)),
                     'giver': Giver(*content['giver']), 'names': tuple(content['names'])})


class MotionTopic:
    """Publishes `motion`, latched."""

    def __init__(self) -> None:
        self._publisher = rospy.Publisher('motion', msg.Motion, queue_size=20, latch=True,
                                          tcp_nodelay=True)

    def publish(self, motion: Motion) -> None:
        """Publishes the new state."""
        message = message_of(motion)
        message.header.stamp = rospy.Time.now()
        self._publisher.publish(message)


def message_of(motion: Motion) -> msg.Motion:
    """A `Motion` as a message, without its stamp."""
    memory = motion.memory
    return msg.Motion(
        epoch=memory.epoch, previous_epoch=memory.previous_epoch, giver=memory.giver.name,
        state=int(motion.state), goal=memory.goal, stop_owed=memory.stop_owed,
        cause=int(memory.cause), reason=memory.reason,
        last_commands=[msg.LastCommand(last.giver, last.number, int(last.fate))
                       for last in memory.last_commands])
