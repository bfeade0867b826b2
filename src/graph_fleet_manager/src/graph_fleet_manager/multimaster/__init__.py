"""Multimaster: checks of the other ROS masters that are joined with this side's master."""
