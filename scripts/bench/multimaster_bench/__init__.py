"""What the benchmark of joined ROS masters runs on either side."""
