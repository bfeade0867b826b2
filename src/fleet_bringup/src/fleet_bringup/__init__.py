"""Makes the launch and RViz files of a whole fleet.

This package depends on all packages of the fleet; no package depends on it.
"""
