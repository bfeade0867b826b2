"""What the robot does: drives, docks, works off tasks."""
