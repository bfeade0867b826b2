"""Lets a person edit a graph. This package does not depend on ROS or on windows."""
