"""Keeps what the bridge must know after a restart: the numbers of orders, and its last route.

The file is not forced to the disk, so it is reliable only within one boot of the computer. After
another boot, the file may lack the last orders that were taken. Then the bridge begins a new epoch,
its route has failed, and the robot is stopped.

The bridge continues a route only if the same launch has restarted the bridge. After a person has
ended a launch and started it again, the robot must not drive by itself. But the ROS master, which
keeps the record, may outlive the launch.
"""
from __future__ import annotations

import http.client
import json
import math
import threading
import xmlrpc.client
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import rospy

from json_records import from_json, to_json
from node_lifecycle.kept_files import hold, in_ros_home, replace_json
from node_lifecycle.worker import start_worker
from omron_ld90.bridge.events import BridgeMemory
from omron_ld90.nodes.support.boot_clock import Moment

PARAMETER = '~route_record'
REFRESHED = 5.0     # s after which an unchanged record is written again


class Recalled(NamedTuple):
    """The record that an earlier run of this program left.

    age     -- s since the record was written; infinite for a record of another launch
    is_sure -- no later record can have been lost
    """

    record: BridgeMemory
    age: float
    is_sure: bool


class RouteMemory:
    """Keeps the record, with its time, in a private parameter and in a file.

    `keep` writes the file before it returns. So the robot never acts on an order that a restarted
    bridge would not know. A separate thread writes the parameter, because the ROS master may answer
    slowly.
    """

    def __init__(self, launch: str = '', file: str = '') -> None:
        """launch -- an id that changes with a new launch, but not with a restart of the node

        file -- path of the file, which survives a restart of the ROS master; a relative path begins
            in ROS_HOME; empty: no file
        """
        self._launch = launch
        self._file = in_ros_home(file)
        self._record: Optional[BridgeMemory] = None
        self._closed = False
        self._writing = threading.Lock()
        self._changed = threading.Condition()
        self._closing = False
        self._thread = start_worker('route-memory', self._run)

    def hold(self) -> None:
        """Reserves the file. Raises ConfigurationError if another bridge uses it."""
        hold(self._file, '~route_file')

    def recall(self) -> Optional[Recalled]:
        """Returns the record that an earlier run left; None if there is none.

        A record of another launch counts as infinitely old, with one exception: if no person ended
        that launch (it crashed), the age of its record in the file counts.
        """
        found: List[Tuple[Moment, BridgeMemory, bool]] = []
        for text, outlives in ((rospy.get_param(PARAMETER, ''), False), (self._read(), True)):
            try:
                content = json.loads(text)
                counts = content['launch'] == self._launch or outlives and not content['closed']
                record = from_json(BridgeMemory, content['record'])
                found.append((Moment.read(content), record, counts))
            except (KeyError, TypeError, ValueError):
                continue
        if not found:
            return None
        now = Moment.now()
        written, record, counts = min(found, key=lambda one: (one[0].age(now), not one[2]))
        return Recalled(record, written.age(now) if counts else math.inf,
                        written.boot == now.boot)

    def keep(self, record: BridgeMemory) -> None:
        """Writes a record if it differs from the last one; see the text of the class."""
        with self._changed:
            is_new = record != self._record
            self._record = record
            if is_new:
                self._changed.notify()
        if is_new:
            self._write_file()

    def close(self) -> None:
        """Writes the last record, and ends the thread."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._thread.join(0.5)

    def _run(self) -> None:
        written: Optional[BridgeMemory] = None
        closing = False
        while not closing and not rospy.is_shutdown():
            with self._changed:
                if self._record == written and not self._closing:
                    self._changed.wait(REFRESHED)
                written = self._record
                self._closed = closing = self._closing
            if written is not None:
                self._write_parameter(self._write_file())

    def _write_file(self) -> Dict[str, Any]:
        """Writes the last record, and returns the written content. Two threads call this."""
        with self._writing:
            assert self._record is not None
            content = {'launch': self._launch, 'closed': self._closed,
                       **Moment.now().content(),
                       'record': to_json(self._record)}
            try:
                if self._file:
                    replace_json(self._file, content)
            except OSError as error:
                rospy.logwarn_throttle(60.0, 'The route is not remembered over a restart of the '
                                             'ROS master: %s cannot be written (%s).', self._file,
                                       error.strerror)
            return content

    @staticmethod
    def _write_parameter(content: Dict[str, Any]) -> None:
        try:
            rospy.set_param(PARAMETER, json.dumps(content))  # a dict would be many parameters
        except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
            rospy.logwarn_throttle(60.0, 'The route cannot be remembered over a restart: the '
                                         'ROS master does not answer (%s).', error)

    def _read(self) -> str:
        """Returns the content of the file; empty if there is no file, or it is not text."""
        try:
            with open(self._file, encoding='utf-8') as stream:
                return stream.read()
        except (OSError, ValueError):
            return ''
