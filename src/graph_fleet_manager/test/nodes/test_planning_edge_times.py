"""Learned times are sent to the planner: first all of them, then only changes."""
from __future__ import annotations

from io import BytesIO
from typing import Dict, Optional, Tuple

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule

from graph_fleet_manager.messages.edge_times import TimesKept, TimesSent
from itrci_nav_msgs import msg

Table = Dict[Tuple[str, int], float]
KEYS = [(kind, edge) for kind in ('agv', 'ld90') for edge in (1, -1, 2, -2, 3)]
tables = st.dictionaries(st.sampled_from(KEYS), st.floats(0.1, 1000.0))
WHOLE: Table = dict.fromkeys(KEYS, 10.0)


class Dialogue:
    """A supervisor that repeats its question until the planner answers, like the nodes."""

    def __init__(self, rate: float = 1.0) -> None:
        self.rate = rate
        self.sent, self.kept = TimesSent(), TimesKept()
        self.plan_id = 0
        self.sizes = []

    def request(self, table: Table) -> msg.PlanRequest:
        """Returns the request that the supervisor publishes."""
        self.plan_id += 1
        return self.filled(msg.PlanRequest(plan_id=self.plan_id), table)

    def filled(self, message: msg.PlanRequest, table: Table) -> msg.PlanRequest:
        """Fills in the times that the planner lacks. Returns the request as it arrives by ROS."""
        self.sent.fill(message, table, self.rate)
        self.sizes.append(len(message.edge_times))
        buffer = BytesIO()
        message.serialize(buffer)
        return msg.PlanRequest().deserialize(buffer.getvalue())

    def table_of(self, message: msg.PlanRequest) -> Optional[Table]:
        """Returns the times that the planner uses; None if it answers OTHER_TIMES."""
        found = self.kept.table_of(message, self.rate)
        return None if found is None else dict(found)

    def ask(self, table: Table) -> Table:
        """Asks once. If the planner lacks times, asks a second time with all times."""
        message = self.request(table)
        found = self.table_of(message)
        if found is None:
            self.sent.is_lost()
            found = self.table_of(self.filled(message, table))
        assert found is not None, 'the planner refused a complete table'
        self.sent.answered(message.plan_id)
        return found


def test_a_table_that_stays_the_same_is_sent_once():
    dialogue = Dialogue()
    for _ in range(5):
        assert dialogue.ask(WHOLE) == WHOLE
    assert dialogue.sizes == [len(WHOLE), 0, 0, 0, 0]


def test_of_a_new_table_only_the_changes_are_sent():
    dialogue = Dialogue()
    dialogue.ask(WHOLE)
    changed = {**WHOLE, ('agv', 1): 12.0}
    del changed['ld90', -2]
    assert dialogue.ask(changed) == changed
    assert dialogue.sizes == [len(WHOLE), 2]


def test_a_planner_that_was_restarted_gets_all():
    dialogue = Dialogue()
    dialogue.ask(WHOLE)
    dialogue.kept = TimesKept()
    assert dialogue.ask(WHOLE) == WHOLE
    assert dialogue.sizes == [len(WHOLE), 0, len(WHOLE)]


def test_a_supervisor_that_was_restarted_sends_all():
    dialogue = Dialogue()
    dialogue.ask(WHOLE)
    dialogue.sent = TimesSent()
    other = {('agv', 1): 3.0}
    assert dialogue.ask(other) == other


def test_a_request_by_hand_without_times_goes_by_none():
    dialogue = Dialogue()
    dialogue.ask(WHOLE)
    assert dialogue.table_of(msg.PlanRequest()) == {}
    assert dialogue.ask(WHOLE) == WHOLE


@pytest.mark.parametrize('rate', [1.0, 5.0])
def test_times_are_those_of_the_robots_however_fast_the_simulation_is(rate):
    assert Dialogue(rate).ask(WHOLE) == pytest.approx(WHOLE)


class LossesAndRestarts(RuleBasedStateMachine):
    """The planner uses the right table after all losses and restarts."""

    @initialize()
    def begin(self):
        self.dialogue = Dialogue()
        self.table: Table = {}

    @rule(table=tables)
    def another_table(self, table):
        self.table = table

    @rule()
    def ask(self):
        assert self.dialogue.ask(self.table) == self.table

    @rule()
    def a_request_is_lost(self):
        self.dialogue.request(self.table)

    @rule()
    def an_answer_is_lost(self):
        found = self.dialogue.table_of(self.dialogue.request(self.table))
        assert found in (None, self.table)

    @rule(count=st.integers(2, 3))
    def requests_are_superseded(self, count):
        messages = [self.dialogue.request(self.table) for _ in range(count)]
        for message in messages:
            assert self.dialogue.table_of(message) in (None, self.table)
        self.dialogue.sent.answered(messages[0].plan_id)

    @rule()
    def the_planner_is_restarted(self):
        self.dialogue.kept = TimesKept()

    @rule()
    def the_supervisor_is_restarted(self):
        self.dialogue.sent = TimesSent()


TestLossesAndRestarts = LossesAndRestarts.TestCase
