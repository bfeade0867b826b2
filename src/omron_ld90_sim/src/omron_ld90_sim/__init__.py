"""A simulated OMRON LD-90 that speaks ARCL.

From the inside out: `motion` is the robot's body on its floor, `devices` what hangs on it,
`behaviour` what it does, and `interface` its ARCL server, on TCP sockets, in a thread or as a
program. Each may import those named before it. Everything runs on one simulated `Clock`.
"""
from omron_ld90_sim.interface.simulator import Simulator

__all__ = ['Simulator']
