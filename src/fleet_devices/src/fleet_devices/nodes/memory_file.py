"""The file that keeps the holders of each device over a restart."""
from __future__ import annotations

import json

import rospy

from fleet_devices.core.devices import StoredDevices
from json_records import from_json, to_json
from node_lifecycle.kept_files import hold, in_ros_home, replace_json


class MemoryFile:
    """Keeps `StoredDevices`; a relative path begins in ROS_HOME."""

    def __init__(self, path: str, parameter: str) -> None:
        """Raises ConfigurationError if another process keeps its memory in the file."""
        self._path = in_ros_home(path)
        hold(self._path, parameter)

    def read(self) -> StoredDevices:
        """Returns what was stored. Nothing: there is no file, or it cannot be read."""
        try:
            with open(self._path, encoding='utf-8') as stream:
                return from_json(StoredDevices, json.load(stream))
        except FileNotFoundError:
            return StoredDevices()
        except (OSError, ValueError, TypeError, RecursionError) as error:
            rospy.logwarn('%s cannot be read, so the holders of the devices are not known: a '
                          'device that is not closed stays as it is until a person gives it back '
                          'with "device release NAME --of unknown". (%s)', self._path, error)
            return StoredDevices()

    def write(self, memory: StoredDevices) -> None:
        """Replaces the file, and forces it to the disk. Raises OSError."""
        replace_json(self._path, to_json(memory), on_disk=True)
