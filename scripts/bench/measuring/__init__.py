"""Common parts of the benchmarks: times, processes, a ROS master of their own, tables."""
