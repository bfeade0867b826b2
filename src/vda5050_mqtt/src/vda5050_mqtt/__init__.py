"""MQTT without ROS: the connection to a broker, the credentials, and brokers of this computer."""
