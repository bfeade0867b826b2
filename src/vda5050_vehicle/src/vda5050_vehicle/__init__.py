"""A VDA 5050 interface for any ROS 1 robot that accepts routes or goal poses.

- `core` and `drivers` depend neither on ROS nor on MQTT.
- `nodes` connects them to ROS and MQTT.
"""
