"""Drives one LD-90 along the routes of a fleet manager: takes orders, gives commands, reports."""
