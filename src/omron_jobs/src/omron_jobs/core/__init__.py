"""Jobs and the lines about them: no ROS, no I/O, no clock.

    job_words       the words and lines of OMRON's Fleet Manager
    jobs            a job; derives the status of its segments from its mission
    job_book        all jobs: accepts, changes and cancels them, follows their missions
    posted_records  cancellations and modifications that REST clients posted
    robots          the states of robots, and why a robot serves no jobs
    command_line    the arguments of a command
    job_commands    carries out commands of clients
    client_session  one client: login, lines in and out
"""
