"""Markers and handles for RViz."""
