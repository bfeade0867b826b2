"""A simulated vehicle that follows the edges of a trajectory graph, and the robot's side of the route protocol."""
