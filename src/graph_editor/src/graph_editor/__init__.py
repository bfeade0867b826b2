"""Trajectory graphs made from a map, checked against it, and edited in RViz.

Metres, radians, m/s. `floor`, `making` and `checking` know nothing of ROS; `nodes` do.
"""
