"""Makes a trajectory graph from a floor.

The steps: make a skeleton, prune it, straighten it into lanes, complete the lanes, number the
vertices and edges.
"""
