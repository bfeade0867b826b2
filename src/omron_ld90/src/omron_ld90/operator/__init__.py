"""The meaning of a person's clicks on the screen, and the messages to that person. No ROS."""
