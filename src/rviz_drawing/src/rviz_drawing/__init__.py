"""Markers for RViz, and the places of robots' labels so that none covers another."""
