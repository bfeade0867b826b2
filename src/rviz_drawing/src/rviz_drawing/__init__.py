"""Markers for RViz, and places for texts so that no text covers another."""
