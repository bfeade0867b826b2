"""The command `device`."""
