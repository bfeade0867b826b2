"""Common parts of the benchmarks: times, processes, separate ROS masters, tables."""
