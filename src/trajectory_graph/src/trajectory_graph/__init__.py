"""The trajectory graph of a robot fleet: vertices, edges, curves, routes."""
