"""The rules for the test of a vehicle.

Each rule is a function with the trial as its argument. It raises Broken or TooLate if the vehicle
breaks the rule, and NotTried if the rule cannot be tried. Rules do not depend on each other.
Section numbers are those of VDA 5050 2.1.0. The sequence of these imports is the sequence of the
run.
"""
from vda5050_bench.rules import (  # isort: skip
    without_order,
    acceptance,
    fields,
    driving,
    over_all,
)
from vda5050_bench.rules.rule import BenchRule, RuleLevel, Start, rules_of
from vda5050_bench.verdicts import Broken, NotTried

__all__ = ['BenchRule', 'Broken', 'NotTried', 'RuleLevel', 'Start', 'acceptance', 'driving',
           'fields',
           'over_all', 'rules_of', 'without_order']
