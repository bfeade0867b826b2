"""The picture of a fleet in RViz, and its menus."""
