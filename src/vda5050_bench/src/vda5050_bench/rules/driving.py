"""Rules for orders that are driven, paused or cancelled, and for the loss of the broker."""
from __future__ import annotations

from typing import Any, Dict, Tuple

from vda5050_bench.master import Message, status_of
from vda5050_bench.rules.rule import ONLY_3, SINCE_2_1, must, should
from vda5050_bench.track import Track
from vda5050_bench.trial import (
    ANSWER,
    NEAR,
    REACH,
    Trial,
    changed,
    has,
    has_order,
    new_errors,
)
from vda5050_bench.verdicts import NotTried, expect

LOOK = 0.2  # s between two checks of the vehicle's position
STOPS = 3  # attempts to stop the vehicle between two nodes
AWAY = 2.0  # s during which the broker is not available


@must('6.10.2', 'a traversed node leaves nodeStates, its edge leaves edgeStates, lastNodeId is set')
def _traversal(trial: Trial) -> None:
    master, track = trial.master, trial.ahead.part(0, 2)
    before = master.count()
    trial.ordered(track)
    node = track.stops[1].node_id
    state = master.wait(lambda s: s['lastNodeId'] == node, trial.patience, f'lastNodeId {node}',
                        after=before)
    expect(state['lastNodeSequenceId'] == 2,
           f'lastNodeSequenceId is {state["lastNodeSequenceId"]}')
    expect(all(item['sequenceId'] > 2 for item in (*state['nodeStates'], *state['edgeStates'])),
           'the node or its edge is still in the state')


@must('6.10.2', 'as soon as a node is traversed, its actions are triggered')
def _triggered(trial: Trial) -> None:
    slow, here = trial.slow_action('HARD'), trial.ahead.part(0, 0)
    before = trial.master.count()
    trial.ordered(here, actions={here.stops[0].node_id: [slow]})
    trial.master.wait(lambda s: status_of(s, slow['actionId']) not in (None, 'WAITING'), ANSWER,
                      f'{slow["actionType"]} at the node of an order of one node',
                      after=before)


@must('6.10.6', 'driving is true while the vehicle drives')
def _driving(trial: Trial) -> None:
    before = trial.master.count()
    trial.ordered(trial.ahead.part(0, 1))
    trial.master.wait(lambda s: s['driving'], trial.patience, 'driving', after=before)


@must('6.10.6', 'a vehicle that has driven its order is idle: no nodeStates, no edgeStates')
def _end(trial: Trial) -> None:
    track = trial.ahead.part(0, 1)
    trial.ordered(track)
    trial.at_end_of(track)


@must('6.6.2', 'the vehicle stops at the decision point and does not drive the horizon')
def _horizon(trial: Trial) -> None:
    decision = trial.ahead.stops[1].node_id
    trial.ordered(trial.ahead, base=2)
    trial.master.wait(lambda s: s['lastNodeId'] == decision and not s['driving'], trial.patience,
                      'standing at the decision point')
    trial.stays(lambda s: s['lastNodeId'] == decision and not s['driving'], 'the decision point')
    expect(len(trial.master.state['edgeStates']) == len(trial.ahead.edges) - 1,
           'the horizon is no longer reported')


@must('6.6.2', 'an order whose base grows is driven on')
def _driven_on(trial: Trial) -> None:
    track = trial.ahead.part(0, 2)
    order_id = trial.ordered(track, base=2)
    trial.accepted(track.part(1).order(order_id, 1, first_sequence=2))
    trial.at_end_of(track)


@must('figure 8 (8)', 'an update that continues a completed order is accepted')
def _continuation(trial: Trial) -> None:
    track = trial.ahead.part(0, 2)
    order_id = trial.ordered(track.part(0, 1))
    trial.needed(lambda: trial.at_end_of(track.part(0, 1)))
    trial.taken(track.part(1).order(order_id, 1, first_sequence=2))
    trial.at_end_of(track)


@must('3.0: 6.1.2', 'a second node at the decision point brings actions to where it stands',
      versions=ONLY_3)
def _second_node(trial: Trial) -> None:
    slow, here = trial.slow_action('HARD'), trial.ahead.part(0, 0)
    order_id = trial.ordered(here)
    twice = Track(here.stops * 2, ('here',), ('here',), here.map_id)
    trial.taken(changed(twice.order(order_id, 1), nodes__1__actions=[slow]))
    trial.master.wait(lambda s: status_of(s, slow['actionId']) not in (None, 'WAITING'), ANSWER,
                      f'{slow["actionType"]} at the second node')


@must('6.8.2', 'startPause: the vehicle stands still, keeps its order and tells paused')
def _pause(trial: Trial) -> None:
    _paused(trial)
    state = trial.master.state
    expect(state.get('paused'), 'paused is not true')
    expect(not state['driving'], 'it still drives')
    expect(state['nodeStates'], 'nodeStates are empty')
    trial.stays(lambda s: not s['driving'], 'standing')


@must('6.8.1', 'stopPause: the movement is resumed')
def _resume(trial: Trial) -> None:
    trial.needed(lambda: _paused(trial))
    master, before = trial.master, trial.master.count()
    status = master.ended(master.act('stopPause'), trial.patience)['actionStatus']
    expect(status == 'FINISHED', f'stopPause is {status}')
    master.wait(lambda s: s['driving'] and not s.get('paused'), trial.patience, 'driving on',
                after=before)


def _paused(trial: Trial) -> None:
    _underway(trial)
    status = trial.master.ended(trial.master.act('startPause'), trial.patience)['actionStatus']
    expect(status == 'FINISHED', f'startPause is {status}')


def _underway(trial: Trial) -> str:
    before = trial.master.count()
    order_id = trial.ordered(trial.ahead)
    trial.needed(lambda: trial.master.wait(lambda s: s['driving'], trial.patience, 'driving',
                                           after=before))
    return order_id


# --- cancellation ---------------------------------------------------------------------------------

@must('6.6.3', 'cancelOrder is FINISHED when all movement has stopped, and the order is deleted')
def _cancel(trial: Trial) -> None:
    _cancelled(trial)
    state = trial.master.state
    expect(not state['driving'], 'it still drives')
    expect(not has_order(state), 'nodeStates or edgeStates remain')
    trial.stays(lambda s: not s['driving'], 'standing')


@must('6.6.3', 'a cancelled order keeps its orderId and orderUpdateId')
def _cancel_keeps_ids(trial: Trial) -> None:
    order_id = trial.needed(lambda: _cancelled(trial))
    expect(has(trial.master.state, {'orderId': order_id, 'orderUpdateId': 0}),
           f'they are {trial.master.state["orderId"]!r}, {trial.master.state["orderUpdateId"]}')


@must('6.6.3', 'cancelOrder: actions that are scheduled are FAILED', versions=SINCE_2_1)
@should('6.6.3', 'cancelOrder: actions that are scheduled are FAILED', versions=('2.0',))
def _cancel_actions(trial: Trial) -> None:
    slow, last = trial.slow_action('HARD'), trial.ahead.stops[-1].node_id
    trial.ordered(trial.ahead, base=1, actions={last: [slow]})
    _cancel_order(trial)
    status = status_of(trial.master.state, slow['actionId'])
    expect(status == 'FAILED', f'the action is {status}')


@must('3.0: 6.1.3.1', 'an update of a cancelled order brings ORDER_UPDATE_FOLLOWING_CANCEL',
      versions=ONLY_3)
def _update_after_cancel(trial: Trial) -> None:
    order_id = trial.ordered(trial.ahead, base=1)
    _cancel_order(trial)
    error = trial.refused(trial.ahead.order(order_id, 1, base=1), 'an update after cancelOrder')
    expect(error.get('typeOf3') == 'ORDER_UPDATE_FOLLOWING_CANCEL',
           f'the error is {error.get("typeOf3")}')


@must('6.6.3.1', 'after a cancellation: an order from the last node, with a large deviation')
def _order_after_cancel(trial: Trial) -> None:
    trial.needed(lambda: _cancelled(trial))
    last = trial.master.state['lastNodeId']
    index = [stop.node_id for stop in trial.ahead.stops].index(last)
    rest = trial.ahead.part(index)
    if index + 1 == len(trial.ahead.stops):
        raise NotTried('the vehicle stopped at the end of the track')
    trial.taken(rest.order(trial.new_id(), start_deviation=REACH))
    trial.at_end_of(rest)


@must('6.6.3.1', 'after a cancellation: an order from a temporary node where the vehicle stands')
def _order_from_temporary_node(trial: Trial) -> None:
    state, index = _stopped_between_nodes(trial)
    pose = state['agvPosition']
    rest = trial.ahead.part(index, index + 1)
    order: Dict[str, Any] = rest.order(trial.new_id())
    first = order['nodes'][0]
    first['nodeId'] = order['edges'][0]['startNodeId'] = f'here-{trial.new_id()}'
    first['nodePosition'] = {'x': pose['x'], 'y': pose['y'], 'mapId': pose['mapId']}
    trial.taken(order)
    trial.at_end_of(rest)


@must('figure 8 (4)', 'an order from a node ahead, within its deviation, is driven or rejected')
def _order_from_node_ahead(trial: Trial) -> None:
    _, index = _stopped_between_nodes(trial, edges_ahead=1)
    rest = trial.ahead.part(index + 1)
    order, was = rest.order(trial.new_id(), start_deviation=REACH), trial.master.state
    before = trial.master.send('order', order)
    state = trial.master.wait(lambda s: has(s, order) or bool(new_errors(was, s)), ANSWER,
                              'the order in the state, or an error', after=before)
    if has(state, order):
        trial.at_end_of(rest)


def _stopped_between_nodes(trial: Trial, edges_ahead: int = 0) -> Tuple[Message, int]:
    """Cancels the order of a vehicle in the middle of an edge, with more edges ahead of it.

    A vehicle needs time to stop and may reach the next node, so there are STOPS attempts.
    Returns the state and the number of the edge; raises NotTried if no attempt succeeds.
    """
    for attempt in range(STOPS):
        if attempt > 0:
            trial.needed(trial.bring_back)
        _underway(trial)
        deadline = trial.master.now() + trial.patience
        while trial.nearest(trial.fetch()) <= 2.0 * NEAR and trial.master.now() < deadline:
            trial.let_pass(LOOK)
        _cancel_order(trial)
        state = trial.fetch()
        index = [stop.node_id for stop in trial.ahead.stops].index(state['lastNodeId'])
        if trial.nearest(state) > NEAR and index + 1 + edges_ahead < len(trial.ahead.stops):
            return state, index
    raise NotTried(f'the vehicle stopped at a node or on the last edge, {STOPS} times')


def _cancel_order(trial: Trial) -> None:
    cancel = trial.master.act('cancelOrder')
    trial.needed(lambda: trial.master.ended(cancel, trial.patience))


def _cancelled(trial: Trial) -> str:
    order_id = _underway(trial)
    status = trial.master.ended(trial.master.act('cancelOrder'), trial.patience)['actionStatus']
    expect(status == 'FINISHED', f'cancelOrder is {status}')
    return order_id


# --- the broker -----------------------------------------------------------------------------------

@must('6.2', 'a vehicle that loses its broker fulfils its order up to the last released node')
def _broker_lost(trial: Trial) -> None:
    master = trial.master
    before, states, _ = _lose_broker(trial)
    after: Message = master.wait(lambda s: True, trial.patience, 'a state', after=states)
    expect(after['lastNodeSequenceId'] > before['lastNodeSequenceId']
           or after.get('agvPosition') != before.get('agvPosition'),
           'it did not drive on without the broker')
    trial.at_end_of(trial.ahead)


@must('6.14', 'a vehicle that comes online again sends ONLINE')
def _online_again(trial: Trial) -> None:
    _, states, connections = _lose_broker(trial)
    trial.master.wait(lambda s: True, trial.patience, 'a state', after=states)
    trial.master.wait(lambda m: m.get('connectionState') == 'ONLINE', ANSWER, 'ONLINE',
                      'connection', connections)


def _lose_broker(trial: Trial) -> Tuple[Message, int, int]:
    """Kills the broker while the vehicle drives, and starts it again.

    Returns the last state before the kill, and the numbers of states and connection messages until
    then.
    """
    master, broker = trial.master, trial.own_broker
    if broker is None:
        raise NotTried('needs --own-broker')
    _underway(trial)
    found = master.state, master.count(), master.count('connection')
    broker.kill()
    master.checker.broker_lost()
    trial.let_pass(AWAY)
    broker.start()
    return found
