"""The decisions of a fleet manager, without ROS: geometry, planning, interlocking, supervision."""
