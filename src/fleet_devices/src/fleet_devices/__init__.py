"""Doors, lights and other devices of a site, driven for the fleet: see `core.device`."""
