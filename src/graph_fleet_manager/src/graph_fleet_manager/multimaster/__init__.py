"""Multimaster: checks of the other ROS master with which this one is joined."""
