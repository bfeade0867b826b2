"""The alarm about a deadline comes before the deadline is missed."""
from __future__ import annotations

from math import inf

from hypothesis import given
from hypothesis import strategies as st

from fleet_core.supervision.mission_times import AGAIN, NEAR, PERIOD, deadline_state
from fleet_core.supervision.missions import DeadlineState

STEPS = st.lists(st.tuples(st.floats(0.0, PERIOD), st.one_of(st.just(inf), st.floats(0.0, 200.0))),
                 min_size=1, max_size=200)


@given(st.floats(20.0, 60.0), STEPS)
def test_whatever_is_estimated_no_deadline_is_missed_without_an_alarm_before(deadline, steps):
    now, before = 0.0, DeadlineState.AHEAD
    for seconds, needed in steps:
        now += seconds
        state = deadline_state(deadline, needed, now, before)
        assert not (before is DeadlineState.AHEAD and state is DeadlineState.MISSED)
        assert (state is DeadlineState.MISSED) is (now > deadline)
        if now + needed > deadline:
            assert state > DeadlineState.AHEAD
        before = state


def test_an_estimate_that_varies_a_little_does_not_change_the_alarm_again_and_again():
    state, told = DeadlineState.AHEAD, []
    for needed in (50.0, 91.0, 89.0, 91.0, 100.0 - AGAIN + 1.0, 100.0 - AGAIN - 1.0):
        state = deadline_state(100.0, needed, 0.0, state)
        told.append(state)
    assert told == [DeadlineState.AHEAD, *[DeadlineState.AT_RISK] * 4, DeadlineState.AHEAD]
    assert NEAR < AGAIN


def test_a_mission_without_a_deadline_has_no_alarm():
    assert deadline_state(0.0, inf, 1e9, DeadlineState.NONE) is DeadlineState.NONE
