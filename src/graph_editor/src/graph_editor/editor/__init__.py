"""The editing of a graph by a person, independent of ROS and of windows."""
