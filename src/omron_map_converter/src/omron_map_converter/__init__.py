"""Converts a trajectory graph into a map: goals, headings, dock, fences. No ROS, no sockets."""
