"""MQTT without ROS: the connection to a broker, the credentials, and an embedded broker."""
