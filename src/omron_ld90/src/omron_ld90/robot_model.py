"""The data of the OMRON LD-90, except its footprint; the bridge and the pictures use them.

Metres, radians, seconds. Sizes, speeds and the laser's range are from the data sheet; accelerations
are from the configurations of real robots. `urdf/ld90.urdf` and the simulator have copies of these
values. A test compares them.
"""
from __future__ import annotations

import math

HEIGHT = 0.383

TOP_SPEED = 1.35  # m/s
TOP_TURN_RATE = math.radians(180.0)  # rad/s; 100 degrees/s on a path
ACCELERATION = 0.5  # m/s2
BRAKING_TO_GOAL = 0.2  # m/s2

LASER_HEIGHT = 0.203  # above the floor
LASER_AHEAD = 0.280  # ahead of the turning centre; not published, taken from the URDF
LASER_FIELD_OF_VIEW = math.radians(240.0)
LASER_RANGE = 15.0
