"""The places that two robots may not hold at once, for planner and interlocking alike."""
