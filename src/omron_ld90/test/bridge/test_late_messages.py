"""A VDA 5050 vehicle passes the bench even if all messages from one program to another are late.

Late messages cause no wrong report and no refusal. For example, if the bridge hears late what the
adapter itself did at a node, the next order is driven nevertheless.
"""
from __future__ import annotations

from dataclasses import fields, replace

import pytest
from bridge_builders import yard
from proofs import is_whole
from vda_stack import VdaDelays, VdaStack

from trajectory_graph import Graph
from vda5050_bench.bench import RuleOutcome, scorecard, tried
from vda5050_bench.layout import track_on
from vda5050_bench.trial import SlowAction, Trial

LATE = 0.4  # s
WAYS = [field.name for field in fields(VdaDelays)] if is_whole(__file__) else ['motions']
GRAPH = Graph(yard().vertices.values(), [
    replace(edge, velocity_forward=1.0, velocity_backwards=1.0) for edge in yard().edges.values()])
# The bench has no broker of its own here, and `wait` is no instant action.
NOT_TRIED = {'needs --own-broker', 'wait is FAILED and did not run'}


@pytest.mark.parametrize('way', WAYS)
def test_a_vehicle_passes_the_bench_although_the_messages_on_one_way_are_late(way):
    stack = VdaStack(GRAPH, 2, VdaDelays(**{way: LATE}))
    trial = Trial(stack.master, track_on(GRAPH, (1, 2, 6), 'map'), 60.0,
                  slow=SlowAction('wait', {'seconds': 5}))
    verdicts = list(tried(trial, '2.1.0'))
    assert {verdict.text for verdict in verdicts
            if verdict.outcome is not RuleOutcome.PASSED} == NOT_TRIED, scorecard(verdicts)
    assert [note for note in stack.notes if 'refused' in note or 'failed' in note] == []
