"""What is asked of each device, what it shows, and what is done: no ROS, no I/O, no clock."""
