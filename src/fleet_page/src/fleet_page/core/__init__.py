"""The content of the page and the permissions, independent of ROS and of the web server."""
