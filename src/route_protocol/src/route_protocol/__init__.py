"""Numbered orders and reports between a master and a vehicle: both ends, without ROS.

`values` has what is sent, `messages` how it is written on the wire, `vehicle` and `master` the two
ends. `intake` says which order waits at a vehicle, and `old_masters` has the rules for masters that
do not number their orders. `steps` and `devices` are the same for the work of robots besides
driving, and for doors and lights; each has its own module of messages.
"""
