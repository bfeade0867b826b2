"""Rules for one order from its acceptance to its end, and for cancellations."""
from __future__ import annotations

from typing import TYPE_CHECKING

from vda5050_vehicle.conformance.master import error_types
from vda5050_vehicle.conformance.rules.rule import QUICK, expect, rejected, rule
from vda5050_vehicle.conformance.track import node_ids

if TYPE_CHECKING:
    from vda5050_vehicle.conformance.bench import Bench


@rule('6.6.2', 'a new order is taken up: first node passed, horizon told, rejections gone')
def _new_order(bench: Bench) -> None:
    master, stops = bench.master, bench.there.stops
    bench.order_id = bench.new_id()
    before = master.send('order', bench.there.order(bench.order_id, base=bench.half + 1))
    state = master.wait(lambda s: s['orderId'] == bench.order_id, QUICK, 'the order', after=before)
    expect(state['lastNodeId'] == stops[0].node_id, 'lastNodeId is not the first node')
    expect(node_ids(state) == [stop.node_id for stop in stops[1:]],
           f'nodeStates are {node_ids(state)}: not all nodes but the first')
    expect([n['released'] for n in state['nodeStates']].count(True) == bench.half,
           'the base is not what was released')
    expect(not {'validationError', 'orderError', 'noRouteError'} & set(error_types(state)),
           'old rejections are still told')


@rule('figure 8 (3)', 'another order while one is under way is refused')
def _other_order(bench: Bench) -> None:
    order = bench.there.order(bench.new_id())
    rejected(bench.master, bench.master.send('order', order), 'orderError', 'another order')


@rule('figure 8 (6)', 'the same update again is ignored')
def _duplicate(bench: Bench) -> None:
    master = bench.master
    was = error_types(master.state)
    before = master.send('order', bench.there.order(bench.order_id, base=bench.half + 1))
    bench.stays(before, lambda s: s['orderId'] == bench.order_id and error_types(s) == was
                and s['orderUpdateId'] == 0, 'the order and no new error')


@rule('6.10.2', 'the state tells that it drives, and nodes that are passed')
def _drives(bench: Bench) -> None:
    master, before = bench.master, bench.master.count()
    master.wait(lambda s: s['driving'], bench.patience, 'driving', after=before)
    master.wait(lambda s: s['lastNodeId'] == bench.there.stops[1].node_id
                and s['lastNodeSequenceId'] == 2, bench.patience, 'the second node passed',
                after=before)


@rule('6.6.2', 'the vehicle stops at the decision point and does not drive the horizon')
def _horizon(bench: Bench) -> None:
    master, decision = bench.master, bench.there.stops[bench.half].node_id
    before = master.count()
    master.wait(lambda s: s['lastNodeId'] == decision and not s['driving'], bench.patience,
                'standing at the decision point', after=before)
    bench.stays(master.count(), lambda s: s['lastNodeId'] == decision, 'the decision point')
    expect(len(master.state['nodeStates']) == len(bench.there.stops) - 1 - bench.half,
           'the horizon is not told any more')


@rule('figure 8 (7)', 'an update that does not begin at the decision point is refused')
def _wrong_stitch(bench: Bench) -> None:
    master, half = bench.master, bench.half
    for what, order in (
            ('an update that begins with the horizon\'s node', bench.there.part(half + 1).order(
                bench.order_id, 1, first_sequence=2 * half + 2)),
            ('an update with another sequenceId', bench.there.part(half).order(
                bench.order_id, 1, first_sequence=2 * half + 4))):
        rejected(master, master.send('order', order), 'orderUpdateError', what)


@rule('figure 8 (7)', 'an update at the decision point is taken up, and driven')
def _update(bench: Bench) -> None:
    master, half = bench.master, bench.half
    before = master.send('order', bench.there.part(half).order(bench.order_id, 2,
                                                               first_sequence=2 * half))
    state = master.wait(lambda s: s['orderUpdateId'] == 2, QUICK, 'the update', after=before)
    expect('orderUpdateError' not in error_types(state), 'old rejections are still told')
    expect(all(n['released'] for n in state['nodeStates']), 'the base did not grow')
    master.wait(lambda s: s['driving'], bench.patience, 'driving on', after=before)


@rule('figure 8 (5)', 'an older update is refused with orderUpdateError')
def _older_update(bench: Bench) -> None:
    order = bench.there.part(bench.half).order(bench.order_id, 1, first_sequence=2 * bench.half)
    rejected(bench.master, bench.master.send('order', order), 'orderUpdateError',
              'an older update')


@rule('6.8.2', 'startPause stops the vehicle and keeps the order; stopPause drives on')
def _pause(bench: Bench) -> None:
    master = bench.master
    ended = master.ended(master.act('startPause'), bench.patience)
    expect(ended['actionStatus'] == 'FINISHED', f'startPause is {ended["actionStatus"]}')
    state = master.state
    expect(state['paused'] and not state['driving'], 'it is not paused, or still drives')
    expect(state['nodeStates'], 'nodeStates are gone')
    bench.stays(master.count(), lambda s: not s['driving'], 'standing')
    before = master.count()
    ended = master.ended(master.act('stopPause'), bench.patience)
    expect(ended['actionStatus'] == 'FINISHED', f'stopPause is {ended["actionStatus"]}')
    master.wait(lambda s: s['driving'] and not s['paused'], bench.patience, 'driving on',
                after=before)


@rule('6.10.6', 'at its end nodeStates are empty and the orderId is kept')
def _end(bench: Bench) -> None:
    state = bench.master.wait(lambda s: not s['nodeStates'] and not s['driving'], bench.patience,
                              'the end of the order')
    expect(state['orderId'] == bench.order_id, 'the orderId is not kept')
    expect(state['lastNodeId'] == bench.there.stops[-1].node_id, 'it is not at the last node')


@rule('figure 8 (8)', 'an update that continues a completed order is taken up')
def _continuation(bench: Bench) -> None:
    master, back = bench.master, bench.there.reversed()
    last = 2 * (len(bench.there.stops) - 1)
    before = master.send('order', back.part(0, 1).order(bench.order_id, 3, first_sequence=last))
    master.wait(lambda s: s['orderUpdateId'] == 3, QUICK, 'the update', after=before)
    master.wait(lambda s: s['lastNodeId'] == back.stops[1].node_id and not s['nodeStates']
                and not s['driving'], bench.patience, 'the end of the continuation', after=before)
    bench.at = 1


# --- cancellation ---------------------------------------------------------------------------------

@rule('6.6.3', 'cancelOrder under way stops the vehicle and empties the order')
def _cancel(bench: Bench) -> None:
    master, rest = bench.master, bench.there.reversed().part(bench.at)
    bench.order_id = bench.new_id()
    before = master.send('order', rest.order(bench.order_id))
    master.wait(lambda s: s['orderId'] == bench.order_id and s['driving'], bench.patience,
                'driving', after=before)
    ended = master.ended(master.act('cancelOrder'), bench.patience)
    expect(ended['actionStatus'] == 'FINISHED', f'cancelOrder is {ended["actionStatus"]}')
    state = master.state
    expect(not state['driving'] and not state['nodeStates'] and not state['edgeStates'],
           'it still drives, or nodeStates are left')
    expect(state['orderId'] == bench.order_id, 'the orderId is not kept')


@rule('6.6.3 (3.0: ORDER_UPDATE_FOLLOWING_CANCEL)', 'an update of a cancelled order is refused')
def _update_after_cancel(bench: Bench) -> None:
    master = bench.master
    order = bench.there.reversed().part(bench.at).order(bench.order_id, 1)
    rejected(master, master.send('order', order), 'orderUpdateError', 'an update after a cancel')


@rule('6.6.3.1', 'after a cancellation the next order is taken up from where the vehicle stands')
def _order_after_cancel(bench: Bench) -> None:
    master = bench.master
    last, back = master.state['lastNodeId'], bench.there.reversed()
    index = [stop.node_id for stop in back.stops].index(last)
    bench.order_id = bench.new_id()
    before = master.send('order', back.part(index).order(bench.order_id, start_deviation=10.0))
    state = master.wait(lambda s: s['orderId'] == bench.order_id, QUICK, 'the order', after=before)
    expect('orderUpdateError' not in error_types(state), 'old rejections are still told')
    bench.lose_broker_meanwhile()
    master.wait(lambda s: not s['nodeStates'] and not s['driving'], bench.patience,
                'the end of the order', after=before)
    expect(master.state['lastNodeId'] == back.stops[-1].node_id, 'it is not at the last node')


@rule('6.9', 'an instant action that comes twice is done once')
def _same_action_twice(bench: Bench) -> None:
    master, sheets = bench.master, bench.master.count('factsheet')
    action_id = master.act('factsheetRequest')
    master.ended(action_id, QUICK)
    master.act('factsheetRequest', action_id)
    master.ended(master.act('stateRequest'), QUICK)
    expect(master.count('factsheet') == sheets + 1, 'it was done twice')
