"""The ROS node of the page, and the conversion of its messages."""
