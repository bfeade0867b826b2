"""VDA 5050 for any ROS 1 robot that takes routes or poses.

`protocol`, `core` and `drivers` know neither ROS nor MQTT, `mqtt` and `conformance` no ROS; `nodes`
join them to both.
"""
