"""graph_server surveys each graph, also as a hardened service that may not change a priority."""
from __future__ import annotations

import os
import threading
from types import SimpleNamespace
from typing import List

import pytest
import rospy
from fleet_builders import AGV, corridor

from fleet_core.fleet import Fleet
from graph_fleet_manager.nodes.graph_server import GraphServer
from itrci_nav_msgs.msg import ParkingPlaces


def test_a_graph_is_surveyed_although_the_priority_may_not_be_changed(
        monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: int) -> None:
        raise PermissionError
    published: List[ParkingPlaces] = []
    server = object.__new__(GraphServer)
    server._fleet, server._lock = Fleet((AGV,), (), 0.1), threading.RLock()
    server._stamp, server._parked_with = rospy.Time(1), frozenset()
    server._closures = SimpleNamespace(edges=frozenset())
    server._parking = SimpleNamespace(publish=published.append)
    monkeypatch.setattr(os, 'setpriority', refuse)
    server._survey(corridor(4), server._stamp)
    assert len(published) == 1 and published[0].vertices
