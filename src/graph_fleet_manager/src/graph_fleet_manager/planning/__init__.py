"""Routes for many robots that stay free of conflict however late robots are; no ROS, no files."""
