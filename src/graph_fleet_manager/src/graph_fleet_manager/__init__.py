"""A fleet manager for robots that drive on a trajectory graph; knows no particular robot."""
