"""The door of the page: a separate process for logins, sessions and stops.

All browsers connect to the door. It passes all other requests to the page's process through a
local socket. The door still answers if the page's process is busy, hangs or grows.
"""
