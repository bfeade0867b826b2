"""Rules for actions and fields of an order that the vehicle cannot honour."""
from __future__ import annotations

import math
from typing import Any, Dict, Optional

from vda5050_bench.master import Message
from vda5050_bench.rules.rule import must
from vda5050_bench.track import Track, action
from vda5050_bench.trial import (
    ANSWER,
    Trial,
    changed,
    has,
    has_order,
    new_errors,
    references,
)
from vda5050_bench.verdicts import Broken, NotTried, expect

TURN = 0.1     # rad; the largest error of a heading
POINT = 0.001  # m; an allowedDeviationXY that hardly any vehicle can keep


@must('6.6.4.2', 'an order with an action that it cannot perform brings the warning orderError')
def _unknown_action(trial: Trial) -> None:
    trial.clear_rejections()
    error = _refused_action(trial)
    expect(error['errorType'] == 'orderError', f'the error is {error["errorType"]}')
    expect(error['errorLevel'] == 'WARNING', f'the errorLevel is {error["errorLevel"]}')


@must('6.6.4.2', 'orderError has the wrong fields as error references')
def _unknown_action_referred(trial: Trial) -> None:
    trial.clear_rejections()
    try:
        error = _refused_action(trial)
    except Broken as problem:
        raise NotTried(str(problem)) from None
    expect(references(error), 'there are no errorReferences')


def _refused_action(trial: Trial) -> Dict[str, Any]:
    where = trial.ahead.stops[1].node_id
    order = trial.ahead.order(trial.new_id(), actions={
        where: [action('noSuchAction', trial.new_id())]})
    return trial.refused(order, 'an unknown action')


@must('6.6.1', 'the pose that the vehicle tells is one that an order may begin with')
def _echo(trial: Trial) -> None:
    """Sends an order with the theta that the vehicle reports.

    The vehicle must not call this order malformed; it may reject the order for other reasons.
    """
    _is_no_malformed_theta(trial, _pose(trial.master.state)['theta'])


@must('6.6.6', 'theta of an order may be anything within [-Pi ... Pi], both included')
def _limits_of_theta(trial: Trial) -> None:
    for theta in (math.pi, -math.pi):
        _is_no_malformed_theta(trial, theta)
        trial.bring_back()


def _is_no_malformed_theta(trial: Trial, theta: float) -> None:
    trial.clear_rejections()
    state, pose = trial.master.state, _pose(trial.master.state)
    order = changed(trial.ahead.part(0, 0).order(trial.new_id()), nodes__0__nodePosition={
        'x': pose['x'], 'y': pose['y'], 'theta': theta, 'allowedDeviationTheta': math.pi,
        'mapId': pose['mapId']})
    before = trial.master.send('order', order)
    answer = trial.master.wait(lambda s: has(s, order) or new_errors(state, s), ANSWER,
                               'the order, or an error', after=before)
    types = [error['errorType'] for error in new_errors(state, answer)]
    expect('validationError' not in types, f'it calls an order with theta {theta!r} malformed')


@must('6.1.1', 'a field of an order is honoured or the order is rejected: theta of the first node')
def _first_theta(trial: Trial) -> None:
    wanted = _wrapped(_pose(trial.master.state)['theta'] + math.pi / 2.0)
    _has_heading(trial, trial.ahead.part(0, 0), 0, wanted)


@must('6.1.1', 'a field of an order is honoured or the order is rejected: theta of the last node')
def _last_theta(trial: Trial) -> None:
    _pose(trial.master.state)
    _has_heading(trial, trial.ahead.part(0, 1), 1, math.pi)


@must('6.1.1', 'a field of an order is honoured or the order is rejected: allowedDeviationXY')
def _deviation(trial: Trial) -> None:
    _pose(trial.master.state)
    track = trial.ahead.part(0, 1)
    state = _driven(trial, track, 1, {'allowedDeviationXY': POINT})
    if state:
        pose, stop = _pose(state), track.stops[1]
        off = math.hypot(pose['x'] - stop.x, pose['y'] - stop.y)
        expect(off <= POINT, f'allowedDeviationXY {POINT:g} is accepted, but the vehicle stands '
                             f'{off:.3f} m from the node')


def _has_heading(trial: Trial, track: Track, index: int, wanted: float) -> None:
    state = _driven(trial, track, index, {'theta': wanted, 'allowedDeviationTheta': TURN})
    if state:
        heading = _pose(state)['theta']
        expect(abs(_wrapped(heading - wanted)) <= TURN,
               f'theta {wanted:.3f} is accepted; in the end it is {heading:.3f}')


def _driven(trial: Trial, track: Track, index: int, fields: Dict[str, Any]) -> Optional[Message]:
    """Drives an order after adding `fields` to the position of the node at `index`.

    Returns the state at the end of the order; None if the order is refused or fails.
    """
    trial.clear_rejections()
    order = track.order(trial.new_id())
    position = order['nodes'][index]['nodePosition']
    order = changed(order, **{f'nodes__{index}__nodePosition': {**position, **fields}})
    was, before = trial.master.state, trial.master.count()
    trial.master.send('order', order)
    state = trial.master.wait(lambda s: has(s, order) or new_errors(was, s), ANSWER,
                              'the order, or an error', after=before)
    if not has(state, order):
        return None
    state = trial.master.wait(
        lambda s: has(s, order) and (new_errors(was, s) or not has_order(s)), trial.patience,
        'the end of the order', after=before)
    if new_errors(was, state):
        return None
    return trial.fetch()


def _pose(state: Message) -> Message:
    pose: Optional[Message] = state.get('agvPosition')
    if not pose:
        raise NotTried('its states have no agvPosition')
    return pose


def _wrapped(angle: float) -> float:
    return math.atan2(math.sin(angle), math.cos(angle))
