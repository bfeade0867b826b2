"""A day of jobs from a file, played in virtual time: no ROS.

    day_file    reads the file
    fleet_desk  the fleet manager and its robots, as the job server uses them
    day_run     plays a day: the job server of `core`, and the program that sends the jobs
    judge       checks the lines to the program against OMRON's order and the robots' drives
    day_report  the figures of a day in words, and as CSV
    command     simulate_jobs
"""
