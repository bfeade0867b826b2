"""Makes trajectory graphs from a map, checks them against the map, and edits them in RViz.

Units are metres, radians and m/s. `floor`, `making` and `checking` do not use ROS; `nodes` do.
"""
