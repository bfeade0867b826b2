"""The site of a fleet: the limits of its graph, the closed edges, and changes of the graph."""
