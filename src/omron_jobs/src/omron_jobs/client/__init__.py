"""Hands jobs of this workspace to an OMRON Fleet Manager: no ROS, no I/O, no clock.

    handed_jobs          a job, its states and the events that change them
    fleet_manager_lines  the lines to and from a Fleet Manager
    job_client           the state machine: all jobs, across links, restarts and cancellations
"""
