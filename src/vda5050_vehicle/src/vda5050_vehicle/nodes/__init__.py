"""The adapter's node and its parts: what joins the vehicle to ROS and to an MQTT broker."""
