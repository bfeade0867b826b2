"""The adapter's node and its parts, which connect the vehicle to ROS and to an MQTT broker."""
