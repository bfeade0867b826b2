"""Rules for a vehicle without an order: what it tells, and what it refuses."""
from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Dict

from vda5050_vehicle.conformance.master import error_types, status_of
from vda5050_vehicle.conformance.rules.rule import QUICK, expect, rejected, rule

if TYPE_CHECKING:
    from vda5050_vehicle.conformance.bench import Bench


@rule('6.14', 'connection is ONLINE and retained')
def _online(bench: Bench) -> None:
    master = bench.master
    found = master.wait(lambda m: True, QUICK, 'a message on connection', 'connection')
    expect(found['connectionState'] == 'ONLINE', f'it is {found["connectionState"]}')
    expect(bench.is_retained('connection'), 'it is not retained')


@rule('6.8.1', 'stateRequest brings a state and is FINISHED')
def _state_request(bench: Bench) -> None:
    master, before = bench.master, bench.master.count()
    action_id = master.act('stateRequest')
    master.wait(lambda s: status_of(s, action_id) == 'FINISHED', QUICK, 'stateRequest FINISHED',
                after=before)


@rule('6.15', 'factsheetRequest brings the factsheet, retained, with its actions')
def _factsheet(bench: Bench) -> None:
    master, before = bench.master, bench.master.count('factsheet')
    action_id = master.act('factsheetRequest')
    sheet = master.wait(lambda m: True, QUICK, 'a factsheet', 'factsheet', before)
    expect(master.ended(action_id)['actionStatus'] == 'FINISHED', 'the action FAILED')
    known = {found['actionType'] for found in sheet['protocolFeatures']['agvActions']}
    expect({'cancelOrder', 'startPause', 'stopPause'} <= known,
           'cancelOrder, startPause or stopPause is not in it')
    expect(bench.is_retained('factsheet'), 'it is not retained')


# --- what is refused without an order -------------------------------------------------------------

@rule('6.9', 'an unknown instant action is told as FAILED')
def _unknown_action(bench: Bench) -> None:
    ended = bench.master.ended(bench.master.act('noSuchAction'), QUICK)
    expect(ended['actionStatus'] == 'FAILED', f'it is {ended["actionStatus"]}')


@rule('6.6.3.2', 'cancelOrder without an order is FAILED, with noOrderToCancel')
def _nothing_to_cancel(bench: Bench) -> None:
    master = bench.master
    ended = master.ended(master.act('cancelOrder'), QUICK)
    expect(ended['actionStatus'] == 'FAILED', f'it is {ended["actionStatus"]}')
    expect('noOrderToCancel' in error_types(master.state), 'there is no noOrderToCancel')


def _damaged(order: Dict[str, Any], **changes: Any) -> Dict[str, Any]:
    """A copy of an order with changes: `nodes__1__released=True` changes nodes[1].released."""
    copy = json.loads(json.dumps(order))
    for path, value in changes.items():
        *parents, last = [int(part) if part.isdigit() else part for part in path.split('__')]
        target: Any = copy
        for part in parents:
            target = target[part]
        target[last] = value
    return copy


@rule('6.6.4.1', 'a malformed order is refused with validationError')
def _malformed(bench: Bench) -> None:
    master = bench.master
    good = bench.there.order(bench.new_id())
    for what, payload in (('broken JSON', b'{"orderId": "x", '), ('no UTF-8', b'\xff\xfe{}'),
                          ('JSON that is no object', b'[1, 2]')):
        rejected(master, master.send_bytes('order', payload), 'validationError', what)
    for what, order in (
            ('a gap in sequenceId', _damaged(good, nodes__1__sequenceId=7)),
            ('an edge that is missing', _damaged(good, edges=good['edges'][1:])),
            ('no nodes', _damaged(good, nodes=[], edges=[])),
            ('a released edge to a node that is not', _damaged(good, nodes__1__released=False)),
            ('an edge between other nodes', _damaged(good, edges__0__endNodeId='elsewhere')),
            ('a nodeId that is a number', _damaged(good, nodes__0__nodeId=5)),
            ('a blockingType that there is not', _damaged(good, nodes__0__actions=[
                {'actionType': 'x', 'actionId': 'y', 'blockingType': 'MAYBE'}]))):
        rejected(master, master.send('order', order), 'validationError', what)


@rule('6.6.4.2', 'an order with an unknown action is refused with orderError')
def _order_with_unknown_action(bench: Bench) -> None:
    order = _damaged(bench.there.order(bench.new_id()), nodes__1__actions=[
        {'actionType': 'noSuchAction', 'actionId': bench.new_id(), 'blockingType': 'NONE'}])
    rejected(bench.master, bench.master.send('order', order), 'orderError', 'an unknown action')


@rule('figure 8 (4)', 'an order that begins far away is refused')
def _far_away(bench: Bench) -> None:
    order = bench.there.reversed().order(bench.new_id())
    rejected(bench.master, bench.master.send('order', order), 'noRouteError orderError',
              'an order that begins far away')
