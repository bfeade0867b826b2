"""A VDA 5050 interface for any ROS 1 robot that accepts routes or goal poses.

- `protocol`, `core` and `drivers` depend neither on ROS nor on MQTT.
- `mqtt` and `conformance` do not depend on ROS.
- `nodes` connects these packages to ROS and MQTT.
"""
