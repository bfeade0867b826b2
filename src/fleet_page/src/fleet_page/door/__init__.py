"""The door of the page: a process of its own, which knows login, session and stop, and little else.

All connections of browsers end here. What is not a login or a stop goes to the page's process
through a local socket. That process may be busy, hang or grow: the door answers all the same.
"""
