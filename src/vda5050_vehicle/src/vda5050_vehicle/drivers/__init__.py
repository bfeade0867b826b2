"""Two drivers that make a robot drive an order: by routes over a graph, or by poses for move_base.

The drivers depend neither on ROS nor on MQTT: they create commands and receive the results.
"""
