"""A message that is too old is not carried out."""
from __future__ import annotations

from typing import Dict, List, Optional

import pytest
from std_msgs.msg import String

from omron_ld90.nodes.support.old_messages import (
    LATCHED,
    STANDSTILL,
    WAITED,
    WAITED_WITHIN,
    OldMessages,
)


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def connection(caller: str, latching: bool = True, process: str = 'first') -> Dict[str, str]:
    return {'callerid': caller, 'latching': '1' if latching else '0', 'process': process}


def message(*words: object, over: Optional[Dict[str, str]] = None) -> String:
    said = String('goto 12')
    said._connection_header = over or connection(*words)
    return said


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def old(clock) -> OldMessages:
    publishers: Dict[str, List[str]] = {'send_command': ['/before', '/also_before']}
    old = OldMessages(lambda topic: publishers.get(topic, []), clock,
                      lambda message: message._connection_header['process'])
    old.watch('send_command')
    old.watch('initialpose')
    return old


def test_the_last_message_of_a_publisher_that_was_there_before_is_old_and_its_next_is_not(old):
    wire = connection('/before')
    assert old.reason(message(over=wire), 'send_command') == LATCHED
    assert old.reason(message(over=wire), 'send_command') is None
    assert old.reason(message('/also_before'), 'send_command', is_stop=True) == LATCHED


def test_a_publisher_that_does_not_latch_or_came_later_is_heard(old):
    assert old.reason(message('/before', False), 'send_command') is None
    assert old.reason(message('/later'), 'send_command') is None
    assert old.reason(message('/before'), 'initialpose') is None
    assert old.reason(String('goto 12'), 'send_command') is None


def test_no_time_makes_a_latched_message_new(old, clock):
    """A publisher that is away at the start comes back later, and sends its latched message."""
    for _ in range(1000):
        clock.now += 1.0
        old.tick(clock.now)
    assert old.reason(message('/before'), 'send_command') == LATCHED


def test_what_a_connection_brings_again_that_broke_and_came_back_is_old(old):
    first, again = connection('/later'), connection('/later')
    assert old.reason(message(over=first), 'send_command') is None
    assert old.reason(message(over=first), 'send_command') is None
    assert old.reason(message(over=again), 'send_command') == LATCHED
    assert old.reason(message(over=again), 'send_command') is None


def test_a_program_that_was_started_again_gives_a_new_command(old):
    assert old.reason(message('/later'), 'send_command') is None
    assert old.reason(message('/later', True, 'second'), 'send_command') is None


def test_what_waited_while_the_process_stood_still_is_old_but_for_a_stop(old, clock):
    wire = connection('/later')
    clock.now += 10.0
    assert old.reason(message(over=wire), 'send_command') == WAITED
    assert old.reason(message(over=wire), 'send_command', is_stop=True) is None
    clock.now += WAITED_WITHIN / 2
    assert old.reason(message(over=wire), 'send_command') == WAITED
    clock.now += WAITED_WITHIN
    assert old.reason(message(over=wire), 'send_command') is None


def test_a_process_that_is_slow_does_not_stand_still(old, clock):
    clock.now += STANDSTILL
    assert old.reason(message('/later'), 'send_command') is None
