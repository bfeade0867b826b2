"""Runs Python nodes as forks of one process that has imported their modules once.

For each node, roslaunch starts the small program `hosted` (C), which requests a fork from the host
of the same launch. So roslaunch still controls respawn, logs, parameters and Ctrl-C, and the launch
file still lists the nodes.
"""
