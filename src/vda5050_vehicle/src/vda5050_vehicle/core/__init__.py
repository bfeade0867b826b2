"""A VDA 5050 vehicle without ROS, MQTT and files: it receives events and returns effects."""
