"""Makes the launch and RViz files of a whole fleet.

It depends on all packages of the fleet; none of them depends on it.
"""
