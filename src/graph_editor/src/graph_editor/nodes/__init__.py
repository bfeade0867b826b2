"""The editor as a ROS node: handles in RViz, the live graph, the window beside it."""
