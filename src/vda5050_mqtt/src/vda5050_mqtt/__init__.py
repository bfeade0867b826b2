"""MQTT without ROS: the connection to a broker, the credentials, and brokers on this computer."""
