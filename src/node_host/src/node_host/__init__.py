"""Runs Python nodes as forks of one process that has imported their modules once.

`hosted` (C) stands for each node towards roslaunch and asks the host of the same launch for a fork;
so respawn, logs, parameters and Ctrl-C stay with roslaunch, and the launch file names the nodes.
"""
