"""The port of the job server: see `job_port`."""
