"""Numbered orders and reports between a master and a vehicle, without ROS: both ends."""
