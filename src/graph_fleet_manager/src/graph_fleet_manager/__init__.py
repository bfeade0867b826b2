"""A fleet manager for robots that drive on a trajectory graph. It depends on no robot type."""
