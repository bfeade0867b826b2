"""The virtual world of the tests: plain AGVs, all events that can happen, and their judges."""
