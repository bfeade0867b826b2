"""The order and the times at which programs start, without processes."""
from __future__ import annotations

from node_host.start_queue import START_WITHIN, StartQueue, delay_after


def queue_with(*keys, at_a_time=2):
    queue = StartQueue(at_a_time)
    for key in keys:
        queue.ask(key, identity=key, now=0.0)
    return queue


def those_that_start(queue, now):
    return list(iter(lambda: queue.next(now), None))


def test_programs_start_in_the_order_in_which_they_are_asked_for_and_few_at_a_time():
    queue = queue_with('a', 'b', 'c', 'd')
    assert those_that_start(queue, 0.0) == ['a', 'b']
    queue.started('b')
    assert those_that_start(queue, 0.1) == ['c']


def test_a_program_that_ends_while_it_starts_makes_room_for_the_next():
    queue = queue_with('a', 'b', 'c')
    those_that_start(queue, 0.0)
    queue.ended('a', failed=True, now=0.1)
    assert those_that_start(queue, 0.1) == ['c']


def test_a_program_that_never_tells_of_its_start_holds_up_the_others_only_for_a_while():
    queue = queue_with('a', 'b', 'c')
    those_that_start(queue, 0.0)
    assert queue.seconds_to_next(0.0) == START_WITHIN
    assert those_that_start(queue, START_WITHIN) == ['c']


def test_a_program_that_is_not_wanted_any_more_does_not_start():
    queue = queue_with('a', 'b', 'c')
    queue.ended('b', failed=True, now=0.0)
    assert those_that_start(queue, 0.0) == ['a', 'c']


def run_once(queue, identity, begin, end, failed=True):
    """Requests a program, and lets it run and end. Returns the time of its start."""
    begin += queue.ask(identity, identity, begin)
    assert queue.next(begin) == identity
    queue.started(identity)
    queue.ended(identity, failed, begin + end)
    return begin


def test_a_program_that_ends_soon_after_each_start_waits_longer_each_time():
    queue, starts, now = StartQueue(), [], 0.0
    for _ in range(5):
        starts.append(run_once(queue, 'a', now, 0.5))
        now = starts[-1] + 0.5
    pauses = [later - earlier - 0.5 for earlier, later in zip(starts, starts[1:])]
    assert pauses == [0.0, 1.0, 2.0, 4.0]


def test_the_pause_has_an_upper_limit():
    assert delay_after(50) == 30.0


def test_a_program_that_waits_for_its_pause_does_not_hold_up_the_others():
    queue = StartQueue(1)
    run_once(queue, 'a', 0.0, 0.1)
    run_once(queue, 'a', 0.1, 0.1)
    queue.ask('a', 'a', 1.0)
    queue.ask('b', 'b', 1.0)
    assert queue.next(1.0) == 'b'
    queue.started('b')
    assert queue.seconds_to_next(1.0) == 1.0
    assert queue.next(2.0) == 'a'


def test_a_program_that_ran_for_long_or_ended_well_starts_again_at_once():
    for lifetime, failed in ((60.0, True), (0.1, False)):
        queue = StartQueue()
        for _ in range(3):
            run_once(queue, 'a', 0.0, 0.1)
        run_once(queue, 'a', 100.0, lifetime, failed)
        assert queue.ask('a', 'a', 200.0) == 0.0


def test_no_look_is_due_where_nothing_waits():
    assert StartQueue().seconds_to_next(0.0) is None
