"""What a person at the screen means by a click, and what that person is told. No ROS."""
