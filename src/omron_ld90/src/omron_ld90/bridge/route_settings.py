"""What a user can set about the driving of routes."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from omron_ld90.bridge.route_strategies import Strategy, rolling


@dataclass(frozen=True)
class Settings:
    """Metres and seconds; the figures of motion are the LD-90's."""

    dock_vertex: Optional[int] = None
    strategy: Strategy = rolling
    native_command: str = ''  # in place of `goto`, with {goals} and {last}
    vertex_tolerance: float = 0.3
    corridor_width: float = 0.9
    stall_timeout: float = 30.0
    location_timeout: float = 5.0
    link_timeout: float = 2.0
    top_speed: float = 1.35
    acceleration: float = 0.5
    braking: float = 0.2      # m/s2, deceleration towards a goal
