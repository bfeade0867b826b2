"""Makes the launch and RViz files of a whole fleet. Knows all packages; none knows it."""
