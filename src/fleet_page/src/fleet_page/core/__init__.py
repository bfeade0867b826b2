"""What the page shows and who may do what: without ROS and without a web server."""
