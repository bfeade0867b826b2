"""The fleet in virtual time: the real supervisor, interlocking and planner on a virtual clock."""
