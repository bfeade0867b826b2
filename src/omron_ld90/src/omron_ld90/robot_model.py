"""The OMRON LD-90 in figures: the one place that converter, bridge and pictures take them from.

Metres, radians, seconds. Sizes, speeds and the laser's reach are the data sheet's; accelerations
stand in the configurations of real robots. `urdf/ld90.urdf` and the simulator, which does not
depend on this package, say the same: a test compares them.
"""
from __future__ import annotations

import math

LENGTH, WIDTH, HEIGHT = 0.699, 0.500, 0.383
HALF_WIDTH = WIDTH / 2
HALF_DIAGONAL = 0.430  # about the turning centre, rounded up

TOP_SPEED = 1.35  # m/s
TOP_TURN_RATE = math.radians(180.0)  # rad/s; 100 degrees/s on a path
ACCELERATION = 0.5  # m/s2
BRAKING_TO_GOAL = 0.2  # m/s2

LASER_HEIGHT = 0.203  # above the floor
LASER_AHEAD = 0.280  # of the turning centre; not published: as it is drawn in the URDF
LASER_FIELD_OF_VIEW = math.radians(240.0)
LASER_RANGE = 15.0
