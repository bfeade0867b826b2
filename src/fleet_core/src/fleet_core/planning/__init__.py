"""Planning: routes for many robots, without conflicts even if robots are late. No ROS, no files."""
