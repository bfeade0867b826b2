"""Masters that use an actionId again, and masters that repeat a refused message for ever."""
from __future__ import annotations

import pytest
from vda_builders import SAY, Lab, way

from vda5050_bench.checker import VehicleChecker
from vda5050_protocol.values import EmergencyStop
from vda5050_vehicle.core import effects as fx
from vda5050_vehicle.core.errors import MAX_REJECTIONS

HALL = way(8, 10, 12, 14, 32)


def under_way():
    """Returns a vehicle that drives."""
    lab = Lab()
    lab.order(HALL.order('o'))
    return lab


# --- actionIds that are used again ----------------------------------------------------------------

def test_a_master_with_one_id_for_all_its_pauses_and_another_for_all_resumptions_is_obeyed():
    """vda5050-sdk uses ids in this way; its second resume() once left the robot paused for ever."""
    lab = under_way()
    for _ in range(3):
        lab.act('startPause', 'pause')
        lab.settle()
        assert (lab.state['paused'], lab.robot.drives) == (True, False)
        lab.act('stopPause', 'resume')
        assert (lab.state['paused'], lab.robot.drives) == (False, True)
        assert lab.status('resume') == 'FINISHED'


@pytest.mark.parametrize('kind, effect', [
    ('stateRequest', fx.SendState), ('factsheetRequest', fx.SendFactsheet)])
def test_a_request_with_a_known_id_is_answered_again(kind, effect):
    lab = Lab()
    for _ in range(3):
        lab.effects.clear()
        lab.act(kind, 'request')
        assert any(isinstance(found, effect) for found in lab.effects)
        assert lab.status('request') == 'FINISHED'


def test_a_resumption_with_a_known_id_that_is_refused_now_is_reported_as_failed():
    lab = under_way()
    lab.act('stopPause', 'resume')
    assert lab.status('resume') == 'FINISHED'
    lab.see(e_stop=EmergencyStop.MANUAL)
    # a new checker, because the old one forbids that an ended action changes
    lab.checker = VehicleChecker('OMRON', 'lab')
    lab.act('stopPause', 'resume')
    assert lab.status('resume') == 'FAILED'


@pytest.mark.parametrize('other', [{'action_type': 'setOutput', 'output': 'lamp'},
                                   {'action_type': 'say', 'text': 'goodbye'},
                                   {'action_type': 'stopPause'}])
def test_another_action_with_the_id_of_one_under_way_is_refused_and_not_dropped(other):
    lab = Lab()
    lab.act('say', 'a', **SAY)
    assert lab.status('a') == 'RUNNING'
    lab.act(action_id='a', **other)
    assert lab.errors == ['instantActionError']
    references = {item['referenceKey']: item['referenceValue']
                  for item in lab.state['errors'][0]['errorReferences']}
    assert references['actionId'] == 'a'
    assert (lab.status('a'), lab.started) == ('RUNNING', ['a'])


@pytest.mark.parametrize('kind', ['say', 'stopPause'])
def test_an_instant_action_with_the_id_of_an_action_of_the_order_is_refused(kind):
    lab = Lab()
    lab.order(HALL.order('o', actions={'12': [{
        'actionType': 'say', 'actionId': 'a', 'blockingType': 'NONE', 'actionParameters': [
            {'key': 'text', 'value': 'hello'}]}]}))
    lab.act(kind, 'a', **(SAY if kind == 'say' else {}))
    assert lab.errors == ['instantActionError']
    assert (lab.status('a'), lab.started) == ('WAITING', [])


# --- masters that repeat themselves ---------------------------------------------------------------

def repeated(lab, send, seconds=10.0):
    """Sends a message 100 times a second; returns the number of new states."""
    before = len(lab.states)
    for _ in range(round(seconds * 100)):
        send()
        lab.now += 0.01
        lab.do(lab.vehicle.tick(lab.now))
    return len(lab.states) - before


@pytest.mark.parametrize('what', ['unreadable', 'elsewhere', 'two in turn', 'instant action'])
def test_a_refusal_that_changes_nothing_is_told_once_a_second(what):
    """Isaac Mission Dispatch sends an order again at every state that does not have its id."""
    lab = Lab()
    send = {'unreadable': lambda: lab.order({'orderId': 'o'}),
            'elsewhere': lambda: lab.order(way(12, 14).order('o')),
            'two in turn': lambda: lab.order(way(12, 14).order(f'o{lab.messages % 2}')),
            'instant action': lambda: lab.act('fly', 'a')}[what]
    send()
    assert len(lab.errors) == 1, 'the first refusal is told at once'
    assert 9 <= repeated(lab, send) <= 12


def test_a_refusal_that_is_new_is_told_at_once():
    lab = Lab()
    for number in range(5):
        states = len(lab.states)
        lab.order(way(12, 14).order(f'o{number}'))
        assert len(lab.states) == states + 1


def test_every_refusal_stays_until_an_order_is_accepted():
    lab = Lab()
    for number in range(50):
        lab.order(way(12, 14).order(f'o{number}'))
    assert len(lab.errors) == 50
    lab.order(HALL.order('o'))
    assert lab.errors == []


def test_a_flood_of_refusals_does_not_make_states_larger_for_ever():
    lab = Lab()
    for number in range(MAX_REJECTIONS + 20):
        lab.order(way(12, 14).order(f'o{number}'))
    assert len(lab.errors) == MAX_REJECTIONS
    assert any(item['referenceValue'] == f'o{MAX_REJECTIONS + 19}'
               for item in lab.state['errors'][-1]['errorReferences'])


# --- the whole kind -------------------------------------------------------------------------------

KINDS = {'say': SAY, 'cancelOrder': {}, 'startPause': {}, 'stopPause': {}, 'stateRequest': {},
         'factsheetRequest': {}, 'logReport': {}, 'startCharging': {}, 'noSuchAction': {}}


@pytest.mark.parametrize('second', KINDS)
@pytest.mark.parametrize('first', KINDS)
@pytest.mark.parametrize('drives', [False, True])
def test_no_instant_action_with_a_known_id_is_dropped_in_silence(first, second, drives):
    """The second action is executed, or it repeats the known action, or an error names it."""
    lab = under_way() if drives else Lab()
    lab.act(first, 'a', **KINDS[first])
    lab.checker = VehicleChecker('OMRON', 'lab')
    lab.act(second, 'a', **KINDS[second])
    lab.wait(1.0)
    shown = next(found for found in lab.state['actionStates'] if found['actionId'] == 'a')
    named = [error for error in lab.state['errors'] if any(
        item == {'referenceKey': 'actionId', 'referenceValue': 'a'}
        for item in error.get('errorReferences', ()))]
    assert shown['actionType'] == second or named
    if second in ('cancelOrder', 'startPause'):
        assert not lab.robot.drives, 'a stop always wins'
