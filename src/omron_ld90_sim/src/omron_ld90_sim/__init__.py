"""A simulated OMRON LD-90 that speaks ARCL.

The packages from the inside out: `motion` is the robot's body on its floor, `devices` are its
devices, `behaviour` are its activities. `interface` is its ARCL server on TCP sockets, in a thread
or as a program. Each may import those named before it. Everything runs on one simulated
`SimClock`.
"""
from omron_ld90_sim.interface.simulator import Simulator

__all__ = ['Simulator']
