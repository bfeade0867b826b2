"""What benchmarks have in common: times, processes, a ROS master of their own, tables."""
