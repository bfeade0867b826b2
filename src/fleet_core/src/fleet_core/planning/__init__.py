"""Planning: routes for many robots, without conflict however late robots are. No ROS, no files."""
