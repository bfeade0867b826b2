"""Routes for many robots that stay free of conflict whatever runs late; no ROS, no files."""
