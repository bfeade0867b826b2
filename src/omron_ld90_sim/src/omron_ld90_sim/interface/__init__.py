"""How the robot is talked to and run: ARCL sessions, configuration, faults, sockets, program."""
