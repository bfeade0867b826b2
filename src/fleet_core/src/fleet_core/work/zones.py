"""Zones: parts of a site in which only a limited number of robots may be at once."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple


@dataclass(frozen=True)
class Zone:
    """A part of a site. A robot claims the zone before it is granted an edge or vertex of it.

    edges    -- ids of its edges
    vertices -- ids of its vertices; the edges at these vertices belong to the zone, too
    capacity -- number of robots that may be in it
    """

    name: str
    edges: Tuple[int, ...] = ()
    vertices: Tuple[int, ...] = ()
    capacity: int = 1
