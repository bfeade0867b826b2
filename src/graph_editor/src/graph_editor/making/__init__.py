"""Makes a trajectory graph from a floor.

The steps: make a skeleton of the floor, prune the skeleton, straighten it into lanes, complete the
lanes, and number the vertices and edges.
"""
