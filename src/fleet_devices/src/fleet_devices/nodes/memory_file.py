"""The files that keep the memory of the devices across a restart."""
from __future__ import annotations

import json
from typing import Generic, TypeVar

import rospy

from json_records import from_json, to_json
from node_lifecycle.kept_files import hold, in_ros_home, replace_json

Kind = TypeVar('Kind')


HOLDERS_LOST = ('the holders of the devices are not known: a device that is not closed stays as it '
                'is until a person gives it back with "device release NAME --of unknown"')
STEPS_LOST = ('the steps of the devices are not known: a person is asked for each step that the '
              'fleet manager waits for')


class MemoryFile(Generic[Kind]):
    """Keeps a value in a file; a relative path begins in ROS_HOME.

    empty  -- the value if nothing was stored
    loss   -- the consequence if the file cannot be read, as a clause
    """

    def __init__(self, path: str, parameter: str, empty: Kind, loss: str) -> None:
        """Raises ConfigurationError if another process keeps its memory in the file."""
        self._path, self._empty, self._loss = in_ros_home(path), empty, loss
        hold(self._path, parameter)

    def read(self) -> Kind:
        """Returns the stored value, or `empty` if there is no file, or it cannot be read."""
        try:
            with open(self._path, encoding='utf-8') as stream:
                return from_json(type(self._empty), json.load(stream))
        except FileNotFoundError:
            return self._empty
        except (OSError, ValueError, TypeError, RecursionError) as error:
            rospy.logwarn('%s cannot be read, so %s. (%s)', self._path, self._loss, error)
            return self._empty

    def write(self, memory: Kind) -> None:
        """Replaces the file, and forces it to the disk. Raises OSError."""
        replace_json(self._path, to_json(memory), on_disk=True)
