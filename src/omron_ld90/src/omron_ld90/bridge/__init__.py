"""Routes of a fleet manager, driven by one LD-90: orders in, commands and reports out. No ROS."""
