"""The bench: a correct vehicle passes. A rule finds each defect, and no defect ends the run."""
from __future__ import annotations

import json
from typing import Dict, List

import pytest
from vda_schemas import problems
from vda_toy_vehicle import LINE, DirectMaster, ToyVehicle

from vda5050_bench.bench import (
    RuleOutcome,
    Verdict,
    read_slow_action,
    scorecard,
    tried,
)
from vda5050_bench.rules import RuleLevel, rules_of
from vda5050_bench.trial import SlowAction, Trial

BLINK = SlowAction('blink')


def verdicts_of(*defects: str, version: str = '2.1.0') -> List[Verdict]:
    """Returns the verdicts on a toy vehicle with these defects."""
    vehicle = ToyVehicle(*defects, version=version)
    return list(tried(Trial(DirectMaster(vehicle), LINE, 30.0, None, BLINK), version))


def found(verdicts: List[Verdict], *outcomes: RuleOutcome) -> Dict[str, str]:
    """Returns what the bench observed for each rule with one of these outcomes.

    The key is the sentence of the rule.
    """
    return {verdict.rule.sentence: verdict.text for verdict in verdicts
            if verdict.outcome in outcomes}


@pytest.mark.parametrize('version', ['2.0.0', '2.1.0', '3.0.0'])
def test_a_vehicle_that_is_right_passes(version):
    verdicts = verdicts_of(version=version)
    assert not found(verdicts, RuleOutcome.BROKEN, RuleOutcome.NOT_FOLLOWED), scorecard(verdicts)
    assert len({verdict.rule.sentence for verdict in verdicts}) == len(verdicts)
    not_tried = found(verdicts, RuleOutcome.NOT_TRIED)
    assert set(not_tried.values()) == {'needs --own-broker'}, scorecard(verdicts)


@pytest.mark.parametrize('version, defect, sentences', [
    ('2.1.0', 'rounds pi', {'every message is as the standard has it'}),
    ('2.1.0', 'refuses pi', {
        'theta of an order may be anything within [-Pi ... Pi], both included'}),
    ('2.1.0', 'accepts beside actions', {
        'a new order is rejected while an action of actionStates has not ended',
        'a new order is rejected while an action of the last order has not ended'}),
    ('2.1.0', 'no actions at the first node', {
        'as soon as a node is traversed, its actions are triggered'}),
    ('2.1.0', 'no references', {
        'the rejection of an order update tells the orderUpdateId',
        'the error of an erroneous order tells its orderId where that can be read',
        'orderError has the wrong fields as error references'}),
    ('2.1.0', 'ignores fields', {
        f'a field of an order is honoured or the order is rejected: {field}'
        for field in ('theta of the first node', 'theta of the last node', 'allowedDeviationXY')}),
    ('2.1.0', 'finds no way to the first node', {
        'an order from a node ahead, within its deviation, is driven or rejected'}),
    ('2.1.0', 'no factsheet', {'the master can request the factsheet by factsheetRequest'}),
    ('2.1.0', 'no pause', {
        'startPause: the vehicle stands still, keeps its order and tells paused'}),
    ('3.0.0', 'clears nothing', {
        'clearInstantActions removes the instant actions that have ended'}),
    ('3.0.0', 'drives every edge', {
        'a second node at the decision point brings actions to where it stands'}),
    ('3.0.0', 'any first update', {'the orderUpdateId of a new order is 0'}),
    ('3.0.0', 'other error after cancel', {
        'an update of a cancelled order brings ORDER_UPDATE_FOLLOWING_CANCEL'}),
    ('3.0.0', 'keeps instant errors', {
        'INVALID_INSTANT_ACTION stays until a new instant action is accepted'})])
def test_the_rule_for_a_defect_finds_it_and_no_other_rule_does(version, defect, sentences):
    verdicts = verdicts_of(defect, version=version)
    broken = found(verdicts, RuleOutcome.BROKEN, RuleOutcome.NOT_FOLLOWED)
    assert set(broken) == sentences, scorecard(verdicts)


def test_advice_that_is_not_followed_is_no_broken_rule():
    verdicts = verdicts_of('no references')
    assert all(verdict.rule.level is RuleLevel.SHOULD for verdict in verdicts
               if verdict.outcome is RuleOutcome.NOT_FOLLOWED)
    assert all(verdict.rule.level is RuleLevel.MUST for verdict in verdicts
               if verdict.outcome is RuleOutcome.BROKEN)


def test_a_vehicle_of_3_0_that_wants_the_ends_of_edges_is_found():
    """VDA 5050 3.0 has no startNodeId and no endNodeId.

    A vehicle that requires them refuses every order of the standard.
    """
    verdicts = verdicts_of('wants the ends of edges', version='3.0.0')
    assert 'a new order is accepted: the state has its orderId, nodes and edges' in found(
        verdicts, RuleOutcome.BROKEN), scorecard(verdicts)


def test_a_vehicle_that_dies_is_tried_again_after_its_return():
    verdicts = verdicts_of('dies')
    not_tried = found(verdicts, RuleOutcome.NOT_TRIED)
    died = [text for text in not_tried.values() if 'has died' in text]
    assert len(died) == 1, scorecard(verdicts)
    assert 'the connection does not break as long as the broker runs' in found(
        verdicts, RuleOutcome.NOT_FOLLOWED)
    assert len(found(verdicts, RuleOutcome.PASSED)) > 40, scorecard(verdicts)


@pytest.mark.parametrize('sentence, level', [
    ('the master can request the factsheet by factsheetRequest', None),
    ('all messages on factsheet are retained', None),
    ('all messages on connection are retained', RuleLevel.SHOULD),
    ('sequenceId runs over nodes and edges, without gaps', RuleLevel.DERIVED)])
def test_2_0_0_demands_only_what_its_text_says(sentence, level):
    found_levels = {rule.sentence: rule.level for rule in rules_of('2.0.0')}
    assert found_levels.get(sentence) is level


def test_a_vehicle_that_falls_silent_is_reported_once():
    verdicts = verdicts_of('silent')
    broken = found(verdicts, RuleOutcome.BROKEN)
    assert list(broken) == ['a state is published on events, or at the latest every 30 s']
    assert set(found(verdicts, RuleOutcome.NOT_TRIED).values()) <= {'the vehicle is silent',
                                                                    'needs --own-broker'}


def test_states_without_a_required_field_end_no_run():
    verdicts = verdicts_of('no batteryState')
    broken = found(verdicts, RuleOutcome.BROKEN)
    assert list(broken) == ['every message is as the standard has it']
    assert 'there is no batteryState, safetyState' in broken[list(broken)[0]]


def test_a_vehicle_that_no_cancellation_stops_is_still_tried_by_all_other_rules():
    verdicts = verdicts_of('drives on')
    assert 'cancelOrder is FINISHED when all movement has stopped, and the order is deleted' \
        in found(verdicts, RuleOutcome.BROKEN), scorecard(verdicts)
    assert len(found(verdicts, RuleOutcome.PASSED)) > 30, scorecard(verdicts)


def test_a_stateRequest_that_is_only_finished_is_answered_by_its_own_actionState():
    assert not found(verdicts_of('no stateRequest'), RuleOutcome.BROKEN)


@pytest.mark.parametrize('garbage', [None, 5, 'text', [5], {'a': 1}])
@pytest.mark.parametrize('key', ['errors', 'nodeStates', 'actionStates', 'agvPosition', 'orderId',
                                 'headerId', 'timestamp'])
def test_no_state_ends_a_run_by_an_exception(key, garbage):
    vehicle = ToyVehicle()
    vehicle.garbage = {key: garbage}
    verdicts = list(tried(Trial(DirectMaster(vehicle), LINE, 5.0, None, BLINK), '2.1.0'))
    assert len(verdicts) == len(rules_of('2.1.0'))


def test_every_rule_cites_a_section_and_a_sentence():
    for rule in {*rules_of('2.1.0'), *rules_of('3.0.0')}:
        assert rule.section[0].isdigit() or rule.section.startswith('figure'), rule
    assert len({rule.sentence for rule in rules_of('3.0.0')}) == len(rules_of('3.0.0'))


def test_a_slow_action_is_read_with_its_parameters():
    assert read_slow_action('noop duration=5 text=hello') == SlowAction(
        'noop', {'duration': 5, 'text': 'hello'})
    assert read_slow_action('') is None
    with pytest.raises(ValueError, match='KEY=VALUE'):
        read_slow_action('noop duration')


# --- the bench's own messages ---------------------------------------------------------------------

# Rules that send orders which do not fit the schema, because a vehicle must refuse them.
MALFORMED = ('an order that cannot be read brings the warning validationError',
             'an order with wrong JSON data types brings validationError',
             'the error of an erroneous order tells its orderId where that can be read',
             'the warning is reported until the vehicle accepts a new order')

# Where text and schema differ, the text is right: in 2.0.0 two names differ in spelling.
OTHER_IN_THE_TEXT = {
    "'actionName' is a required property",
    'actions.actionType: the schema of 2.0.0 has no such key',
    'nodes.nodePosition.allowedDeviationXY: the schema of 2.0.0 has no such key'}


@pytest.mark.parametrize('version', ['2.0.0', '2.1.0', '3.0.0'])
def test_what_the_bench_sends_is_as_the_official_schemas_have_it(version):
    """The author may misread the standard; then wrong messages of the bench would prove nothing."""
    vehicle = ToyVehicle(version=version)
    trial = Trial(DirectMaster(vehicle), LINE, 30.0, None, BLINK)
    run, sent, wrong = tried(trial, version), 0, {}
    for verdict in run:
        for topic, payload in trial.master.sent[sent:]:
            if verdict.rule.sentence not in MALFORMED:
                found = problems(version, topic, json.loads(payload))
                wrong.update({(topic, text): verdict.rule.sentence for text in found
                              if text not in OTHER_IN_THE_TEXT})
        sent = len(trial.master.sent)
    assert not wrong
    assert any(topic == 'order' for topic, _ in trial.master.sent)
