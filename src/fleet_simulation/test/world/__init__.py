"""The virtual world of the tests: plain AGVs, all events that can happen, and checks of the fleet.
"""
