"""An order is sent, and repeated unchanged, until it is acknowledged."""
from __future__ import annotations

import pytest

from graph_fleet_manager.interlocking.orders import Order, Sending
from graph_fleet_manager.interlocking.pending_order import REPEAT, PendingOrder

DRIVE, STOP = Order(7, 3, (1, 2)), Order(8, 4, ())


@pytest.fixture
def pending():
    return PendingOrder()


def test_nothing_is_due_where_nothing_was_ordered(pending):
    assert pending.due(0.0) is None and not pending.is_stop and not pending.is_new_motion


def test_an_order_is_due_at_once_and_again_after_a_while_until_it_is_dropped(pending):
    pending.give(DRIVE)
    assert pending.due(10.0) == Sending(7, (1, 2))
    assert pending.due(10.0 + REPEAT / 2) is None
    assert pending.due(10.0 + REPEAT) == Sending(7, (1, 2), repeated=True)
    pending.drop()
    assert pending.due(20.0) is None


def test_another_order_is_due_at_once_and_is_no_repeat(pending):
    pending.give(DRIVE)
    pending.due(10.0)
    pending.give(STOP, takes_away=True)
    assert pending.is_stop and pending.due(10.1) == Sending(8, ())


def test_new_motion_is_what_was_never_sent_and_takes_nothing_away(pending):
    pending.give(DRIVE)
    assert pending.is_new_motion
    pending.due(0.0)
    assert not pending.is_new_motion
    pending.give(DRIVE._replace(edges=(1,)), takes_away=True)
    assert not pending.is_new_motion


def test_an_order_ends_on_the_track_where_its_last_edge_does():
    assert DRIVE.end == 5 and STOP.end == 4


@pytest.mark.parametrize(('takes_away', 'sent'), [(False, 55), (True, 0)])
def test_an_order_carries_the_epoch_in_which_it_was_decided_unless_it_takes_away(
        pending, takes_away, sent):
    pending.give(Order(7, 0, (1, 2)), takes_away, known_epoch=55)
    assert [pending.due(now).known_epoch for now in (10.0, 10.0 + REPEAT)] == [sent, sent]
