"""Parts of `fleet.py`: graphs, fleets, rivals, and a fleet at work."""
