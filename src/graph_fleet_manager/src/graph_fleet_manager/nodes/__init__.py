"""The ROS nodes of the fleet manager."""
