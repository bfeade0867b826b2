"""The rules that a vehicle is tried against, in the order in which one run can try them all.

Each rule is a function of the bench; it raises Broken, or TooLate, where the vehicle breaks it.
Section numbers are those of VDA 5050 2.1.0. The order of these imports is that of the run.
"""
from vda5050_vehicle.conformance.rules import (  # isort: skip
    without_order,
    with_order,
    over_all,
)
from vda5050_vehicle.conformance.rules.rule import QUIET, RULES, Broken, NotTried, Rule

__all__ = ['QUIET', 'RULES', 'Broken', 'NotTried', 'Rule', 'over_all', 'with_order',
           'without_order']
