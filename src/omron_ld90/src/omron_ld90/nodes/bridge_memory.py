"""Keeps the record of the bridge's last route over a restart.

The bridge continues a route in two cases only: the same launch has restarted the bridge, or the
whole computer died. The ROS master may outlive a launch, and after a person ends a launch and
starts it again, the robot must not drive by itself.
"""
from __future__ import annotations

import http.client
import json
import math
import threading
import xmlrpc.client
from typing import Any, Dict, List, Optional, Tuple

import rospy

from node_lifecycle.worker import start_worker
from omron_ld90.bridge.events import RouteRecord
from omron_ld90.nodes.support.boot_clock import Moment
from omron_ld90.nodes.support.kept_files import hold, in_ros_home, replace_json
from route_protocol.values import EpochCause, Phase, reason_of
from route_protocol.vehicle import VehicleState

PARAMETER = '~route_record'
REFRESHED = 5.0     # s after which an unchanged record is written again


class RouteMemory:
    """Keeps the record of the route, with its time, in a private parameter and in a file.

    A separate thread writes it, because the master may be slow to answer.
    """

    def __init__(self, launch: str = '', file: str = '') -> None:
        """`launch`: an id that changes with a new launch, but not with a restart of the node.

        `file`: unlike the parameter, it survives a restart of the ROS master; empty: no file. A
        relative path begins in ROS_HOME.
        """
        self._launch = launch
        self._file = in_ros_home(file)
        self._record: Optional[RouteRecord] = None
        self._changed = threading.Condition()
        self._closing = False
        self._thread = start_worker('route-memory', self._run)

    def hold(self) -> None:
        """Raises ConfigurationError if another bridge keeps its route in that file."""
        hold(self._file, '~route_file')

    def recall(self) -> Tuple[Optional[RouteRecord], float]:
        """The record left by the program before this one, and its age in s; None without one.

        A record of another launch counts as infinitely old. Exception: it is in the file and no
        person ended that launch, so its computer died.
        """
        found: List[Tuple[Moment, RouteRecord, bool]] = []
        for content, outlives in ((rospy.get_param(PARAMETER, None), False), (self._read(), True)):
            try:
                counts = content['launch'] == self._launch or outlives and not content['closed']
                found.append((Moment.read(content), _record_of(content), counts))
            except (KeyError, TypeError, ValueError):
                continue
        if not found:
            return None, 0.0
        now = Moment.now()
        written, record, counts = min(found, key=lambda one: (one[0].age(now), not one[2]))
        return record, written.age(now) if counts else math.inf

    def keep(self, record: Optional[RouteRecord]) -> None:
        """Gives a record to the thread that writes it."""
        with self._changed:
            if record != self._record:
                self._record = record
                self._changed.notify()

    def close(self) -> None:
        """Writes what is pending and ends the thread."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._thread.join(0.5)

    def _run(self) -> None:
        written: Optional[RouteRecord] = None
        closing = False
        while not closing and not rospy.is_shutdown():
            with self._changed:
                if self._record == written and not self._closing:
                    self._changed.wait(REFRESHED)
                record = written = self._record
                closing = self._closing
            if record is not None:
                self._write({'launch': self._launch, 'closed': closing, **_content_of(record)})

    def _write(self, content: Dict[str, Any]) -> None:
        if self._file:
            try:
                replace_json(self._file, content)
            except OSError as error:
                rospy.logwarn_throttle(60.0, 'The route is not remembered over a restart of the '
                                             'ROS master: %s cannot be written (%s).', self._file,
                                       error.strerror)
        try:
            rospy.set_param(PARAMETER, content)
        except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
            rospy.logwarn_throttle(60.0, 'The route cannot be remembered over a restart: the '
                                         'ROS master does not answer (%s).', error)

    def _read(self) -> Any:
        """The content of the file; None if there is no file or it is not JSON."""
        try:
            with open(self._file, encoding='utf-8') as stream:
                return json.load(stream)
        except (OSError, ValueError):
            return None


def _content_of(record: RouteRecord) -> Dict[str, Any]:
    return {**Moment.now().content(), 'route_id': record.route_id, 'edges': list(record.edges),
            'stamp': str(record.stamp),  # more than the 32 bits of a parameter
            'phase': record.phase.value, 'reason': record.reason.text,
            'reason_code': int(record.reason.code), 'completed': record.completed,
            'target': -1 if record.target is None else record.target, 'goal': record.goal,
            'owes_stop': record.owes_stop, 'epoch': str(record.epoch),
            'past': [[id, str(edges)] for id, edges in record.past], 'base': record.base,
            'protocol': None if record.protocol is None else _content_of_protocol(record.protocol)}


def _content_of_protocol(state: VehicleState) -> Dict[str, Any]:
    """Numbers have more than the 32 bits of a parameter."""
    return {'epoch': str(state.epoch), 'cause': int(state.cause),
            'master': '' if state.master is None else state.master,
            'has_master': state.master is not None,
            'order': str(state.order), 'refused': str(state.refused),
            'refusal': state.refusal.text, 'refusal_code': int(state.refusal.code),
            'done': state.done, 'route_id': state.route_id, 'first': state.first,
            'edges': list(state.edges), 'phase': state.phase.value, 'reason': state.reason.text,
            'reason_code': int(state.reason.code)}


def _record_of(content: Dict[str, Any]) -> RouteRecord:
    """The record in a parameter; raises KeyError, TypeError or ValueError if it contains none."""
    target = int(content['target'])
    return RouteRecord(int(content['route_id']), tuple(int(id) for id in content['edges']),
                       int(content['stamp']), Phase(content['phase']),
                       reason_of(content.get('reason_code', 0), str(content['reason'])),
                       int(content['completed']), None if target < 0 else target,
                       str(content['goal']), bool(content['owes_stop']), int(content['epoch']),
                       tuple((int(id), int(edges)) for id, edges in content['past']),
                       int(content.get('base', 0)), _protocol_of(content.get('protocol')))


def _protocol_of(content: Optional[Dict[str, Any]]) -> Optional[VehicleState]:
    """The protocol's state in a record; None: the record is of a version without numbers."""
    if content is None:
        return None
    return VehicleState(
        int(content['epoch']), EpochCause(content['cause']),
        str(content['master']) if content['has_master'] else None, int(content['order']),
        int(content['refused']), reason_of(content['refusal_code'], str(content['refusal'])),
        int(content['done']), int(content['route_id']), int(content['first']),
        tuple(int(id) for id in content['edges']), Phase(content['phase']),
        reason_of(content['reason_code'], str(content['reason'])))
