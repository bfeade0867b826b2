"""A simulated OMRON LD-90 with its ARCL server.

The packages, from the inside out: `motion` is the robot's body on its floor, `devices` are its
devices, and `behaviour` are its activities. `interface` is its ARCL server on TCP sockets; it runs
in a thread or as a program. Each package may import those named before it. Everything runs on one
simulated `SimClock`.
"""
from omron_ld90_sim.interface.simulator import Simulator

__all__ = ['Simulator']
