"""Numbered orders and reports between a master and a vehicle: both ends, without ROS.

`values` has the data that is sent, and `messages` its form on the wire. `vehicle` and `master` are
the two ends. `intake` decides which order waits at a vehicle, and `old_masters` has the rules for
masters that do not number their orders. `steps` has the protocol for the other work of robots, and
`devices` has the protocol for doors and lights. Each of these two has its own module of messages.
"""
