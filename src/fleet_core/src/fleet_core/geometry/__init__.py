"""The places that two robots may not hold at once, for both the planner and the interlocking."""
