"""The node `job_server` and its private parts."""
