"""Drives one LD-90 along the routes of a fleet manager, and reports to the fleet manager."""
