"""Missions become routes that robots drive: accepted, assigned, released, never lost. No ROS."""
