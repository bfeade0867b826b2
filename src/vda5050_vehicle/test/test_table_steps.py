"""Steps of missions that the table of actions of the LD-90 defines."""
from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from route_protocol.steps import StepAct, StepCode, StepCommand, Word
from vda5050_vehicle.core.action_table import ActionTable, read_table
from vda5050_vehicle.core.table_steps import PATIENCE, TableSteps

FILE = Path(__file__).resolve().parents[1] / 'config/ld90/actions.yaml'
TABLE = ActionTable(read_table(yaml.safe_load(FILE.read_text())))
RUN = 7


class Link:
    def __init__(self):
        self.is_up, self.started, self.cancelled = True, [], []

    def is_ready(self, spec):
        return self.is_up

    def start(self, name, spec, arguments):
        self.started.append((name, spec.call.fields(arguments)))

    def cancel(self, name):
        self.cancelled.append(name)


@pytest.fixture
def link():
    return Link()


@pytest.fixture
def steps(link):
    return TableSteps(TABLE, link, RUN)


def do(key, type, **parameters):
    return StepCommand(key, StepAct.DO, RUN, type, tuple(parameters.items()), 60.0)


def shown(steps, key):
    step = steps.report().find(key)
    return step.word, step.code


def test_a_step_becomes_the_goal_of_the_table_and_its_end_is_shown(steps, link):
    steps.receive(do(1, 'say', text='Mind the cart.'), 0.0)
    assert link.started == [('1', {'command': 'say Mind the cart.'})]
    assert shown(steps, 1) == (Word.RUNNING, StepCode.NONE)
    steps.ended('1', True, 'ok')
    assert shown(steps, 1) == (Word.DONE, StepCode.NONE)
    steps.receive(do(1, 'say', text='again'), 0.0)
    assert len(link.started) == 1


def test_nobody_knows_what_a_step_did_that_began_and_did_not_succeed(steps):
    steps.receive(do(1, 'setOutput', output='gripper'), 0.0)
    steps.ended('1', False, 'LOST')
    assert shown(steps, 1) == (Word.UNKNOWN, StepCode.OTHER)
    assert steps.report().find(1).text == 'LOST'


@pytest.mark.parametrize('command, code, told', [
    (do(1, 'fly'), StepCode.UNKNOWN_TYPE, 'no step fly'),
    (do(1, 'startCharging'), StepCode.UNKNOWN_TYPE, 'moves the robot'),
    (do(1, 'say'), StepCode.WRONG_PARAMETER, 'needs the parameter text'),
    (do(1, 'say', text='a', loud='1'), StepCode.WRONG_PARAMETER, "no parameter 'loud'"),
    (do(1, 'say', text='a\nshutdown'), StepCode.WRONG_PARAMETER, 'must match'),
    (do(1, 'wait'), StepCode.WRONG_PARAMETER, 'seconds must be'),
    (do(1, 'wait', seconds='-1'), StepCode.WRONG_PARAMETER, 'seconds must be'),
    (do(1, 'wait', seconds='1', minutes='2'), StepCode.WRONG_PARAMETER, "no parameter 'minutes'")])
def test_a_step_that_the_table_does_not_have_has_failed_and_nothing_was_begun(
        steps, link, command, code, told):
    steps.receive(command, 0.0)
    assert shown(steps, 1) == (Word.FAILED, code) and not link.started
    assert told in steps.report().find(1).text


def test_a_wait_ends_after_its_time(steps, link):
    steps.receive(do(1, 'wait', seconds='2.5'), 10.0)
    steps.tick(12.4)
    assert shown(steps, 1)[0] is Word.RUNNING
    steps.tick(12.5)
    assert shown(steps, 1)[0] is Word.DONE and not link.started


def test_a_step_waits_for_its_server_but_not_for_ever(steps, link):
    link.is_up = False
    for key in (1, 2):
        steps.receive(do(key, 'say', text='hello'), 0.0)
        steps.tick(PATIENCE - 0.1)
        assert shown(steps, key)[0] is Word.RUNNING and not link.started
        link.is_up = key == 1
        steps.tick(PATIENCE)
        link.is_up = False
        link_started, link.started = link.started, []
        assert bool(link_started) is (key == 1)
    assert shown(steps, 2) == (Word.FAILED, StepCode.NOT_READY)


def test_a_cancellation_ends_what_was_not_begun_and_is_passed_on_otherwise(steps, link):
    steps.receive(do(1, 'wait', seconds='60'), 0.0)
    steps.receive(do(2, 'say', text='hello'), 0.0)
    for key in (1, 2):
        steps.receive(StepCommand(key, StepAct.CANCEL, RUN), 1.0)
    assert shown(steps, 1)[0] is Word.CANCELLED and shown(steps, 2)[0] is Word.RUNNING
    assert link.cancelled == ['2']
    steps.ended('2', False, 'preempted')
    assert shown(steps, 2)[0] is Word.UNKNOWN
