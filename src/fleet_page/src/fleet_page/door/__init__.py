"""The door of the page: a separate process that does login, session and stop, and little else.

All connections of browsers end here. The door passes all other requests to the page's process
through a local socket. The door still answers if that process is busy, hangs or grows.
"""
