"""Translates jobs to values of the fleet manager's core: no ROS, no I/O, no clock."""
