"""ROS nodes: they read parameters, build objects, connect callbacks, and spin."""
