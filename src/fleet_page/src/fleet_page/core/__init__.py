"""The content of the page, and the permissions. It needs neither ROS nor the web server."""
