"""What the page shows, and which role permits which act: without ROS and without a web server."""
