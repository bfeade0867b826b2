"""Two ways to make a robot drive an order: routes over a graph, or poses for move_base.

Neither ROS nor MQTT is known here: drivers make commands, and are told what became of them.
"""
