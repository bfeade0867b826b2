"""Learned times of edges in requests to the planner: first the whole table, then only changes.

The supervisor numbers its tables. In a request, `edge_times_version` is the number of the table to
use. `edge_times_since` is the number of an earlier table, and `edge_times` are the changes since
then. If `edge_times_since` is 0, `edge_times` is the whole table. A time of 0 removes an entry.
A planner without the earlier table, for example after a restart, answers OTHER_TIMES. The
supervisor then sends the whole table.
"""
from __future__ import annotations

from random import SystemRandom
from typing import Dict, List, Optional, Tuple

from fleet_core.planning.plan_requests import Times
from itrci_nav_msgs import msg

_VERSIONS = 2 ** 32


class TimesSent:
    """The supervisor's side: notes which table the planner has."""

    def __init__(self) -> None:
        self._version = SystemRandom().randrange(1, _VERSIONS)  # differs after each start
        self._table: Times = {}
        self._asked: Tuple[int, int, Times] = (-1, 0, {})  # plan id, version and table
        self._known: Tuple[int, Times] = (0, {})

    def fill(self, message: msg.PlanRequest, table: Times, rate: float) -> None:
        """Puts a table, or its changes, into a request. `rate`: seconds of the robots' time in one
        second of ROS time.
        """
        if table is not self._table and table != self._table:
            self._version = self._version % (_VERSIONS - 1) + 1
        self._table = table
        since, before = self._known
        message.edge_times_version, message.edge_times_since = self._version, since
        message.edge_times = _messages(changes(before, table), rate)
        self._asked = message.plan_id, self._version, table

    def answered(self, plan_id: int) -> None:
        """Notes that the planner has answered a request, so it has the table of this request."""
        asked, version, table = self._asked
        if asked == plan_id:
            self._known = version, table

    def is_lost(self) -> None:
        """Notes that the planner has lost its table."""
        self._known = 0, {}


class TimesKept:
    """The planner's side: keeps the last table that the supervisor sent."""

    def __init__(self) -> None:
        self._version = 0
        self._table: Times = {}

    def table_of(self, message: msg.PlanRequest, rate: float) -> Optional[Times]:
        """Returns the table that a request uses; None: the request changes a table that the planner
        does not have.
        """
        told = {(one.robot_type, one.edge_id): one.seconds * rate for one in message.edge_times}
        if not message.edge_times_since:
            self._table = told
        elif message.edge_times_since == self._version:
            if told:
                self._table = changed(self._table, told)
        elif message.edge_times_version != self._version:
            return None
        self._version = message.edge_times_version
        return self._table


def changes(before: Times, after: Times) -> Dict[Tuple[str, int], float]:
    """Returns the changes from one table to another; 0.0 removes an entry."""
    if before is after:
        return {}
    gone = dict.fromkeys(before.keys() - after.keys(), 0.0)
    return {**gone, **{key: seconds for key, seconds in after.items()
                       if before.get(key) != seconds}}


def changed(before: Times, told: Times) -> Times:
    """Returns the table that results from the changes `told`."""
    after = {**before, **told}
    return {key: seconds for key, seconds in after.items() if seconds != 0.0}


def _messages(times: Times, rate: float) -> List[msg.EdgeTime]:
    return [msg.EdgeTime(kind, edge, seconds / rate) for (kind, edge), seconds in times.items()]
