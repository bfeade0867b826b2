"""The rules that a vehicle is tried against.

Each rule is a function of the trial. It raises Broken or TooLate where the vehicle breaks it, and
NotTried where it cannot be tried. Rules do not build on each other. Section numbers are those of
VDA 5050 2.1.0. The order of these imports is that of the run.
"""
from vda5050_vehicle.conformance.rules import (  # isort: skip
    without_order,
    acceptance,
    fields,
    driving,
    over_all,
)
from vda5050_vehicle.conformance.rules.rule import Level, Rule, Start, rules_of
from vda5050_vehicle.conformance.verdicts import Broken, NotTried

__all__ = ['Broken', 'Level', 'NotTried', 'Rule', 'Start', 'acceptance', 'driving', 'fields',
           'over_all', 'rules_of', 'without_order']
