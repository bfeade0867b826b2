"""ROS nodes: read parameters, build objects, connect callbacks, spin."""
