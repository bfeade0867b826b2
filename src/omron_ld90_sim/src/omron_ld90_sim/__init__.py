"""A simulated OMRON LD-90 that speaks ARCL.

From the inside out: `kinematics`, `floor`, `planner`, `track` and `laser` are the robot's body and
world; `robot`, `executive` and `activities` are what it does; `server`, `session` and `commands`
are its ARCL interface, without I/O; `transport` puts that on TCP sockets, `simulator` runs it in a
thread (for tests) and `cli` as a program. Everything runs on one simulated `Clock`.
"""
from omron_ld90_sim.interface.simulator import Simulator

__all__ = ['Simulator']
