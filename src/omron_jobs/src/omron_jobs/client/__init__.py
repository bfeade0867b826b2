"""Hands jobs of this workspace to an OMRON Fleet Manager: no ROS, no I/O, no clock.

    handed_jobs          a job, its states and the events that change them
    fleet_manager_lines  the lines that are sent to a Fleet Manager, and those that are read
    job_client           the state machine: all jobs, across links, restarts and cancellations
"""
