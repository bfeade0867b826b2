"""The activities of the robot: driving, docking, tasks."""
