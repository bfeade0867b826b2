"""What `fleet.py` measures with: graphs, fleets, rivals, a fleet at work."""
