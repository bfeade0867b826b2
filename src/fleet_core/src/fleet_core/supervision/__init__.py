"""Supervision of missions: accepts them, assigns robots, and grants routes. Does not use ROS."""
