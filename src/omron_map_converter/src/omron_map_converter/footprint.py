"""The footprint of the OMRON LD-90, in metres, from the data sheet.

`urdf/ld90.urdf` of `omron_ld90` and the simulator, which does not depend on this package, have the
same values: a test compares them.
"""
from __future__ import annotations

LENGTH, WIDTH = 0.699, 0.500
HALF_WIDTH = WIDTH / 2
HALF_DIAGONAL = 0.430  # distance from the turning centre to a corner, rounded up
