"""Joined ROS masters: what one side can find out about the other, and what is wrong with it."""
