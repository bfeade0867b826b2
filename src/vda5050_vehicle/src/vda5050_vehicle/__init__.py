"""VDA 5050 for any ROS 1 robot that takes routes or poses.

`protocol` and `core` know neither ROS nor MQTT, `drivers` neither either; `nodes` join them to both.
"""
