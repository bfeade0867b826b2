"""The interface of the robot: ARCL sessions, configuration, faults, sockets, and the program."""
