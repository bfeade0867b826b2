"""The files of a fleet: robots, missions, plans."""
