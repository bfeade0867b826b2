"""Missions that wait for other missions.

A mission may name only missions that were accepted before it. So missions cannot wait for each
other in a ring.
"""
from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Until(IntEnum):
    """What a mission waits for, as in itrci_nav_msgs/MissionDependency."""

    DONE = 0    # the other mission must succeed; otherwise the waiting mission fails
    ENDED = 1   # the end of the other mission


@dataclass(frozen=True)
class Dependency:
    """Another mission that must end first.

    mission -- request id of the other mission
    serial  -- serial of the other mission; 0: the waiting mission is not accepted yet
    """

    mission: int
    until: Until = Until.DONE
    serial: int = 0
