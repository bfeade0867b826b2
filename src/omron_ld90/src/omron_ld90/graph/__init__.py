"""What is the LD-90's in the trajectory graph: goals, fences, routes, progress."""
