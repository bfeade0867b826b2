"""Figure 17: actions that may run at the same time, and actions for which the vehicle stands."""
from __future__ import annotations

import pytest

from vda5050_protocol.action_queue import (
    MAX_ENDED_INSTANT_ACTIONS,
    ActionQueue,
    QueuedAction,
    Scope,
)
from vda5050_protocol.values import ActionStatus, BlockingType, VdaAction


def queue_of(kinds):
    return ActionQueue().with_entries(*(
        QueuedAction(VdaAction('say', f'{n}{kind}', BlockingType(kind)), Scope.NODE, 2)
        for n, kind in enumerate(kinds)))


def startable(queue, standing=True):
    return [entry.action.action_id for entry in queue.startable(standing)]


def started(queue, action_ids):
    for action_id in action_ids:
        queue = queue.updated(action_id, ActionStatus.RUNNING)
    return queue


N, S, H = 'NONE', 'SOFT', 'HARD'


@pytest.mark.parametrize('kinds, rounds', [
    ([N, N], [['0NONE', '1NONE']]),
    ([N, S], [['0NONE', '1SOFT']]),
    ([H, N], [['0HARD'], ['1NONE']]),
    ([N, H, S], [['0NONE'], ['1HARD'], ['2SOFT']]),
    ([N, S, H, H, N], [['0NONE', '1SOFT'], ['2HARD'], ['3HARD'], ['4NONE']])])
def test_what_runs_at_once(kinds, rounds):
    queue = queue_of(kinds)
    assert not startable(queue), 'no action may run before its node is reached'
    queue = queue.with_element_triggered(2)
    for together in rounds:
        assert startable(queue) == together
        queue = started(queue, together)
        assert not startable(queue)
        for action_id in together:
            queue = queue.updated(action_id, ActionStatus.FINISHED)
    assert queue.order_has_ended


def test_while_it_drives_only_actions_that_let_it_are_started():
    queue = queue_of([N, S, N])
    queue = queue.with_element_triggered(2)
    assert startable(queue, standing=False) == ['0NONE', '2NONE']
    assert queue.forbid_driving


def test_a_node_is_stopped_at_only_for_actions_that_need_it():
    assert queue_of([N, S]).next_stop(0) == 2
    assert queue_of([N, N]).next_stop(0) is None
    assert queue_of([H]).next_stop(2) is None


def test_an_action_ends_once():
    queue = queue_of([N])
    queue = queue.with_element_triggered(2)
    queue = queue.updated('0NONE', ActionStatus.FINISHED, 'done')
    queue = queue.updated('0NONE', ActionStatus.FAILED, 'late')
    assert (queue['0NONE'].status, queue['0NONE'].result) == (ActionStatus.FINISHED, 'done')
    queue = queue.with_element_triggered(2)
    assert not startable(queue)


def test_a_new_order_keeps_running_instant_actions_only():
    queue = queue_of([N])
    queue = queue.with_entries(*(QueuedAction(VdaAction('say', name, BlockingType.NONE),
                                              Scope.INSTANT)
                                 for name in ('running', 'ended')))
    queue = queue.updated('running', ActionStatus.RUNNING)
    queue = queue.updated('ended', ActionStatus.FINISHED)
    queue = queue.without_order()
    assert [state.action_id for state in queue.states] == ['running']


def test_ended_instant_actions_do_not_pile_up_for_ever():
    queue = ActionQueue()
    for n in range(3 * MAX_ENDED_INSTANT_ACTIONS):
        queue = queue.with_entries(
            QueuedAction(VdaAction('stateRequest', str(n), BlockingType.NONE), Scope.INSTANT))
        queue = queue.updated(str(n), ActionStatus.FINISHED)
    assert len(queue.states) <= MAX_ENDED_INSTANT_ACTIONS + 1
