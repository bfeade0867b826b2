"""MQTT without ROS: the connection to a broker, credentials, and a broker of one's own."""
