"""A VDA 5050 vehicle without ROS, MQTT and files: it is told what happens, and says what to do."""
