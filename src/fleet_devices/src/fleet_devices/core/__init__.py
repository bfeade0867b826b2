"""The requests for devices, their readings, and the resulting commands: no ROS, I/O or clock."""
