"""The editor as a ROS node: handles in RViz, the live graph, and the window beside RViz."""
