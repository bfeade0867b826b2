"""Missions that wait for other missions.

A mission may name only missions that were accepted before it. So no ring of missions can wait for
each other.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Until(IntEnum):
    """What a mission waits for, as in itrci_nav_msgs/MissionDependency."""

    DONE = 0    # the other one has succeeded; if it ends otherwise, this one has failed
    ENDED = 1   # the other one has ended


@dataclass(frozen=True)
class Dependency:
    """Another mission that must end first.

    mission -- its request id
    serial  -- its serial; 0: the mission that waits is not accepted yet
    """

    mission: int
    until: Until = Until.DONE
    serial: int = 0
