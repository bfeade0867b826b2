"""The content of the page, and who may do what; independent of ROS and of the web server."""
