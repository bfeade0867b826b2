"""Work at destinations: stops, their steps, and the load that they move."""
