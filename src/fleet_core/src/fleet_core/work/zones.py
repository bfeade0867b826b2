"""Zones: parts of a site in which only a limited number of robots may be at once."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple


@dataclass(frozen=True)
class Zone:
    """A part of a site. A robot claims it before it is granted one of its edges or vertices.

    edges    -- ids of its edges
    vertices -- ids of its vertices; the edges at them belong to it as well
    capacity -- number of robots that may be in it
    """

    name: str
    edges: Tuple[int, ...] = ()
    vertices: Tuple[int, ...] = ()
    capacity: int = 1
