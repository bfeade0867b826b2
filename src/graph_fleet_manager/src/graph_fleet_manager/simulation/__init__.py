"""Simulated robots that follow the edges of a graph. No ROS."""
