"""Runs Python nodes as forks of one process that has imported their modules once.

`hosted` (C) stands for each node at roslaunch, and requests a fork from the host of the same
launch. So roslaunch still controls respawn, logs, parameters and Ctrl-C, and the launch file still
lists the nodes.
"""
