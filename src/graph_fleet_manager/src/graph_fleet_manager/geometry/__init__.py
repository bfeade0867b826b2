"""Which places two robots may not hold at once; planner and interlocking rely on it alike."""
