"""Numbered orders and reports of master and vehicle: no code yet, a model in the tests."""
