"""The program that the benchmark of joined ROS masters runs on each side."""
