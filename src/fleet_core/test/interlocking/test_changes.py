"""Each reader of the changes of robots gets each change once."""
from __future__ import annotations

from typing import List

from hypothesis import given
from hypothesis import strategies as st

from fleet_core.interlocking.changes import Changes


@given(st.lists(st.sampled_from(['a', 'b', 'c', 'read 0', 'read 1']), max_size=30))
def test_each_reader_gets_the_robots_that_changed_since_it_read_in_the_order_of_change(
        steps: List[str]) -> None:
    changes = Changes()
    readers = [changes.follow(), changes.follow()]
    expected: List[List[str]] = [[], []]
    for step in steps:
        if step.startswith('read'):
            reader = int(step[-1])
            assert readers[reader]() == expected[reader]
            expected[reader] = []
        else:
            number = changes.of(step)
            changes.add(step)
            assert changes.of(step) > number
            expected = [[*(name for name in names if name != step), step] for names in expected]
