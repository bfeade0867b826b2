"""Hands jobs of this workspace to an OMRON Fleet Manager: no ROS, no I/O, no clock.

    handed_jobs          a job, its states and what changes them
    fleet_manager_lines  the lines that are sent to a Fleet Manager, and those that are read
    job_client           the machine: all jobs over links, restarts and cancellations
"""
