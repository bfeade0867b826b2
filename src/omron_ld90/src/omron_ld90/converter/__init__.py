"""From a trajectory graph to a map: goals, headings, dock, fences. No ROS, no sockets."""
