"""A simulated vehicle that follows edges: the robot's side of the route protocol."""
