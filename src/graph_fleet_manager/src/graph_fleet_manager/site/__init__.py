"""The place where a fleet drives: what its graph allows, what of it is closed, when it may change.
"""
