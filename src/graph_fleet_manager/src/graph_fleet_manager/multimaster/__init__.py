"""Multimaster: checks of another ROS master with which this side's master is joined."""
