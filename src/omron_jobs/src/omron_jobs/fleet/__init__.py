"""What jobs are to the fleet manager's core, in its own values: no ROS, no I/O, no clock."""
