"""What the robot says: one frozen dataclass per kind of line, by families."""
