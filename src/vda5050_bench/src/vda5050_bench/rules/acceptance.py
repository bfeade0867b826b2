"""Rules for orders and updates that a vehicle must accept, ignore or refuse: figure 8.

Most rules use an order of which only the first node is released. Such an order keeps the vehicle
busy, so no rule has to wait for a drive.
"""
from __future__ import annotations

from functools import partial
from typing import Any, Dict, Tuple

from vda5050_bench.master import error_types, status_of
from vda5050_bench.rules.rule import (
    ONLY_2,
    ONLY_3,
    SINCE_2_1,
    Start,
    derived,
    must,
    should,
)
from vda5050_bench.track import node_ids
from vda5050_bench.trial import (
    ANSWER,
    ENDED,
    Trial,
    changed,
    has,
    is_idle,
    references,
)
from vda5050_bench.verdicts import Broken, NotTried, expect


@must('6.6.2, figure 8', 'a new order is accepted: the state has its orderId, nodes and edges')
def _new_order(trial: Trial) -> None:
    order = trial.ahead.order(trial.new_id(), base=1)
    state = trial.taken(order)
    wanted = [stop.node_id for stop in trial.ahead.stops]
    expect(node_ids(state) in (wanted, wanted[1:]), f'nodeStates are {node_ids(state)}')
    expect([edge['edgeId'] for edge in state['edgeStates']] == list(trial.ahead.edges),
           'edgeStates are not all edges')
    expect(not any(node['released'] for node in state['nodeStates']
                   if node['nodeId'] != wanted[0]), 'the horizon is reported as released')


@must('figure 8 (3)', 'another order while one is under way, or waits for an update, is rejected',
      versions=SINCE_2_1)
def _other_order(trial: Trial) -> None:
    trial.ordered(trial.ahead, base=1)
    trial.refused(trial.ahead.order(trial.new_id()), 'another order')


@must('figure 8 (3)', 'a new order is rejected while an action of actionStates has not ended',
      versions=('2.1',))
def _order_beside_instant_action(trial: Trial) -> None:
    master, slow = trial.master, trial.slow_action()
    master.act_all([slow])
    _runs(trial, slow)
    trial.refused(trial.ahead.order(trial.new_id()), 'an order while an instant action runs')


@must('figure 8 (3)', 'a new order is rejected while an action of the last order has not ended',
      versions=SINCE_2_1)
def _order_beside_action(trial: Trial) -> None:
    slow = trial.slow_action('HARD')
    trial.ordered(trial.ahead.part(0, 0), actions={trial.ahead.stops[0].node_id: [slow]})
    _runs(trial, slow)
    trial.refused(trial.ahead.order(trial.new_id()), 'an order while an action runs')


def _runs(trial: Trial, slow: Dict[str, Any]) -> None:
    name = slow['actionId']
    state = trial.master.wait(lambda s: status_of(s, name), ANSWER, f'{slow["actionType"]}')
    if status_of(state, name) in ENDED:
        raise NotTried(f'{slow["actionType"]} is {status_of(state, name)} and did not run')


@must('figure 8 (4)', 'an order whose first node is not where the vehicle stands is rejected')
def _far_away(trial: Trial) -> None:
    trial.refused(trial.ahead.reversed().order(trial.new_id()), 'an order that begins far away')


@must('3.0: figure 8 (4)', 'the orderUpdateId of a new order is 0', versions=ONLY_3)
def _new_order_with_update_id(trial: Trial) -> None:
    trial.refused(trial.ahead.order(trial.new_id(), update=5, base=1),
                  'a new order with orderUpdateId 5')


@must('6.6.4.3', 'the same orderId with a lower orderUpdateId is rejected: orderUpdateError')
def _older_update(trial: Trial) -> None:
    order_id = trial.ordered(trial.ahead, base=1)
    trial.accepted(trial.ahead.order(order_id, 2, base=1))
    error = trial.refused(trial.ahead.order(order_id, 1, base=1), 'an older update')
    expect(error['errorType'] == 'orderUpdateError', f'the error is {error["errorType"]}')
    expect(error['errorLevel'] == 'WARNING', f'the errorLevel is {error["errorLevel"]}')


@must('6.6.4.3', 'the same orderId and orderUpdateId twice: the second order is ignored')
def _duplicate(trial: Trial) -> None:
    master = trial.master
    order_id = trial.ordered(trial.ahead, base=1)
    was = error_types(master.state)
    order = trial.ahead.order(order_id, base=1)
    master.send('order', order)
    trial.stays(lambda s: has(s, order) and error_types(s) == was, 'the order, and no new error')


@must('figure 8 (7)', 'an update of a running order must begin with its decision point')
def _wrong_stitch(trial: Trial) -> None:
    order_id = trial.ordered(trial.ahead, base=1)
    for what, order in (
            ('an update that begins with a node of the horizon',
             trial.ahead.part(1).order(order_id, 1, base=1, first_sequence=2)),
            ('an update with another sequenceId of the decision point',
             trial.ahead.order(order_id, 2, base=1, first_sequence=2))):
        trial.refused(order, what)


@must('6.6.6', 'the rejection of an order update tells the orderUpdateId')
def _reference_of_update(trial: Trial) -> None:
    order_id = trial.ordered(trial.ahead, base=1)
    error = trial.refused(trial.ahead.part(1).order(order_id, 7, base=1, first_sequence=2),
                          'an update that begins with a node of the horizon')
    found = references(error)
    expect(found.get('orderUpdateId') == '7', f'errorReferences are {found}')


@must('6.6.2', 'an update at the decision point is accepted, and replaces the horizon')
def _update(trial: Trial) -> None:
    order_id = trial.ordered(trial.ahead, base=1)
    state = trial.taken(trial.ahead.part(0, 1).order(order_id, 1, base=1))
    wanted = [stop.node_id for stop in trial.ahead.stops[:2]]
    expect(node_ids(state) in (wanted, wanted[1:]),
           f'nodeStates are {node_ids(state)}: the old horizon is not replaced')


# --- malformed orders -----------------------------------------------------------------------------

@must('6.6.4.1', 'an order that cannot be read brings the warning validationError', Start.ANYWHERE)
def _unreadable(trial: Trial) -> None:
    for what, payload in (('broken JSON', b'{"orderId": "x", '), ('not UTF-8', b'\xff\xfe{}'),
                          ('JSON that is not an object', b'[1, 2]')):
        trial.clear_rejections()
        error = trial.refused_bytes(partial(trial.master.send_bytes, 'order', payload), what)
        _is_validation_error(what, error)


@must('figure 8 (1), 6.6.4.1', 'an order with wrong JSON data types brings validationError')
def _malformed(trial: Trial) -> None:
    _all_refused(trial, {
        'a nodeId that is a number': {'nodes__0__nodeId': 5},
        'released that is text': {'nodes__0__released': 'yes'},
        'nodes that are not an array': {'nodes': {}},
        'a blockingType that does not exist': {'nodes__0__actions': [
            {'actionType': 'x', 'actionId': 'y', 'blockingType': 'MAYBE'}]}}, is_malformed=True)


@must('6.6.1', 'a valid order has a node or more, and one edge less than nodes')
def _counts(trial: Trial) -> None:
    order = trial.ahead.order('')
    _all_refused(trial, {'no nodes': {'nodes': [], 'edges': []},
                         'a missing edge': {'edges': order['edges'][1:]}})


@must('6.6.1', 'an edge is released only if both its nodes are; nothing released follows a horizon')
def _base(trial: Trial) -> None:
    _all_refused(trial, {'a released edge to a node that is not released': {
                             'nodes__1__released': False},
                         'released elements after an edge that is not released': {
                             'edges__1__released': False}})


@must('3.0: 6.1.1', 'the sequenceId is continuous within an order', versions=ONLY_3)
@derived('6.6.2', 'sequenceId runs over nodes and edges, without gaps', versions=ONLY_2)
def _gaps(trial: Trial) -> None:
    _all_refused(trial, {'a gap in sequenceId': {'nodes__1__sequenceId': 7}})


@should('6.6.6', 'an edge joins the nodes before and after it', versions=ONLY_2)
def _joins(trial: Trial) -> None:
    _all_refused(trial, {'an edge between other nodes': {'edges__0__endNodeId': 'elsewhere'}})


def _all_refused(trial: Trial, damages: Dict[str, Dict[str, Any]], is_malformed: bool = False,
                 ) -> None:
    problems = []
    for what, changes in damages.items():
        try:
            trial.clear_rejections()
            order = changed(trial.ahead.order(trial.new_id()), **changes)
            error = trial.refused(order, what)
            if is_malformed:
                _is_validation_error(what, error)
        except Broken as problem:
            problems.append(str(problem))
            if not is_idle(trial.master.state):
                trial.bring_back()
    expect(not problems, '; '.join(problems))


def _is_validation_error(what: str, error: Dict[str, Any]) -> None:
    expect(error['errorType'] == 'validationError', f'{what}: it is {error["errorType"]}')
    expect(error['errorLevel'] == 'WARNING', f'{what}: the errorLevel is {error["errorLevel"]}')


@should('7.1', 'the error of an erroneous order tells its orderId where that can be read')
def _reference_of_order(trial: Trial) -> None:
    order_id, error = _rejection(trial)
    found = references(error)
    expect(found.get('orderId') == order_id, f'errorReferences are {found}')


@must('6.6.4.1', 'the warning is reported until the vehicle accepts a new order')
def _until_accepted(trial: Trial) -> None:
    _, error = _rejection(trial)
    trial.stays(lambda s: error in s['errors'], f'{error["errorType"]} before a new order')
    trial.ordered(trial.ahead.part(0, 0))
    trial.master.wait(lambda s: error not in s['errors'], ANSWER,
                      f'no {error["errorType"]} any more after a new order')


def _rejection(trial: Trial) -> Tuple[str, Dict[str, Any]]:
    """Returns the orderId and the error of a wrong order that this vehicle refuses."""
    damages: Tuple[Dict[str, Any], ...] = (
        {'nodes__0__released': 'yes'}, {'edges': []}, {'nodes__1__sequenceId': 7})
    for changes in damages:
        trial.bring_back()
        trial.clear_rejections()
        order_id = trial.new_id()
        try:
            return order_id, trial.refused(changed(trial.ahead.order(order_id), **changes), '')
        except Broken:
            continue
    raise NotTried('the vehicle refuses no malformed order')
