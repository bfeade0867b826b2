"""Markers for RViz, and the places of texts so that none covers another."""
